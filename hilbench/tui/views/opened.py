"""Something that has fields, field by field: what each is called, its value in its unit, and whether it is plotted."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from rich.text import Text

from hilbench.tui.model.frames import Field
from hilbench.tui.views.words import DIM, HEAD, LIT, fit

__all__ = ["opened_view"]

_NAME_AT = 24


def opened_view(
    title: str, said: str, fields: Sequence[Field], width: int, height: int, *, field: int, plotted: Collection[str]
) -> list[Text]:
    """Return it.

    Args:
        title: what it is called.
        said: what is said of it besides.
        fields: of it.
        width: cells in a line.
        height: lines there are.
        field: the number of the field that is pointed at.
        plotted: the names of the fields that are plotted.
    """
    room = max(1, height - 1)
    begin = max(0, min(field - room // 2, len(fields) - room))
    breadth = max((len(one.quantity.label) for one in fields), default=0)
    rows = [
        _field(one, breadth, width, points=number == field, plotted=one.name in plotted)
        for number, one in enumerate(fields[begin : begin + room], begin)
    ]
    return [
        fit(Text.assemble((title, HEAD), (f"  {said}", DIM)), width),
        *(rows or [fit(Text("no fields to show", DIM), width)]),
    ]


def _field(field: Field, breadth: int, width: int, *, points: bool, plotted: bool) -> Text:
    mark = "●" if plotted else "○" if field.numbers else " "
    text = Text.assemble(
        ("▸" if points else " ", HEAD),
        (f"{mark} ", "green" if plotted else DIM),
        (f"{field.quantity.label:<{breadth}}  ", HEAD),
        f"{field.text} ",
        (field.quantity.unit, DIM),
    )
    text.pad_right(_NAME_AT + breadth - text.cell_len)
    text.append(f" {field.name}", DIM)
    text = fit(text, width)
    return Text(f"{text.plain:<{width}}", LIT) if points else text
