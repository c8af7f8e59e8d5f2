"""A message that somebody edits and sends: what is typed, what it makes, and where it goes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import pytest

from hilbench.tui.model.editing import edited, text_in, values_of
from protocols import p2os
from tests.each import each


class Way(Enum):
    LEFT = 1
    RIGHT = 2


@dataclass(frozen=True)
class Turn:
    way: Way = Way.LEFT
    share: float = 0.5
    times: int = 3
    on: bool = True
    tail: bytes = b"\x01"
    name: str = "a"
    argument: object = None


class Read(NamedTuple):
    servo: int


@each(
    ("field", "typed", "value"),
    [
        ("way", "RIGHT", Way.RIGHT),
        ("share", "-1e-3", -0.001),
        ("times", "0x10", 16),
        ("on", "No", False),
        ("tail", "FF 00", b"\xff\x00"),
        ("name", "b", "b"),
        ("argument", "-7", -7),
        ("argument", "hey", b"hey"),
        ("argument", "", None),
    ],
)
def test_a_value_is_typed_as_it_is_shown(field, typed, value):
    shown = {name: text_in(one) for name, one in values_of(Turn()).items()}
    assert edited(Turn(), shown) == Turn()
    made = edited(Turn(), shown | {field: typed})
    assert (getattr(made, field), text_in(getattr(made, field)).lower()) == (value, text_in(value).lower())


def test_what_is_no_value_is_said_and_a_named_tuple_will_do():
    assert edited(Read(1), {"servo": "2"}) == Read(2)
    for field, typed, why in (("times", "3.5", "whole number"), ("tail", "F", "bytes in hex"), ("way", "UP", "value")):
        with pytest.raises(ValueError, match=f"{field}: '{typed}' is no {why}"):
            edited(Turn(), {field: typed})


def test_a_message_is_edited_and_sent(process_of, on_screen):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        pane = app.query_one("#messages")
        app.set_focus(pane)
        pane.chosen = ("", True, "RVEL")
        await pilot.press("e")
        await pilot.pause()
        form = app.screen
        form.query_one("#field-argument").value = "x"
        await pilot.pause()
        assert form.query_one("#send").disabled is True
        await pilot.press("ctrl+s")
        assert app.screen is form
        form.query_one("#field-argument").value = "-25"
        form.query_one("#field-argument").focus()
        await pilot.press("enter")
        assert not process.sent
        await pilot.press("ctrl+s")
        await pilot.pause()
        frame = p2os.encode_command(p2os.Command(p2os.CommandNumber.RVEL, -25))
        assert process.sent == [("send", {"data": frame.hex()})]

    on_screen(process, scenario, (160, 50))


def test_a_message_is_opened_and_a_field_of_it_plotted(process_of, on_screen, rows, settle):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        await pilot.press("M", "down", "enter", "down", "down", "down", "enter")
        await settle(app, pilot)
        assert app.query_one("#plots").plotted[0] == "< Sip.th_raw"
        assert "▸● heading" in "\n".join(rows(app))
        await pilot.press("escape", "escape", "escape", "9")
        await settle(app, pilot)
        assert "< Sip.th_raw" in "\n".join(rows(app))

    on_screen(process, scenario, (160, 50))
