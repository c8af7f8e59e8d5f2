"""A screen as SVG: each letter in its cell."""

from __future__ import annotations

from rich.cells import cell_len

from hilbench.tui.svg import in_cells
from tests.each import each

CELL = 12.2


def run(at, text):
    return (
        f'<text class="t-r1" x="{at * CELL:g}" y="20" textLength="{cell_len(text) * CELL:g}" clip-path="url(#l)">'
        f"{text.replace('&', '&amp;').replace('<', '&lt;').replace(' ', '&#160;')}</text>"
    )


@each(
    ("told", "places"),
    [
        ("a word & <more>", [(0, "a word & <more>")]),
        ("   after spaces", [(3, "after spaces")]),
        ("⠤⠤ x", [(0, "⠤"), (1, "⠤"), (3, "x")]),
        ("│up ●", [(0, "│"), (1, "up "), (4, "●")]),
        ("字a", [(0, "字"), (2, "a")]),
        ("    ", []),
    ],
)
def test_a_run_is_cut_where_a_letter_may_have_another_width(told, places):
    assert in_cells(run(5, told)) == "".join(run(5 + at, text) for at, text in places)
