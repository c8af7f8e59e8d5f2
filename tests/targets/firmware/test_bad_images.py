"""Images that go wrong: how each ends, where, why, and that it ends alike however it is run."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from targets.firmware import image_names
from tests.each import each

LIMIT_MS = 500
OTHER_TIMING = pytest.mark.exhaustive("the other timing model; the gate has golden traces with it")


@dataclass(frozen=True)
class End:
    """How an image ends.

    Attributes:
        kind: of `Ended`.
        place: function and line; empty where there is no code of the image.
        pc: address, where the place says nothing.
        words: what the cause says.
        after_ms: bench time, from the earliest to the latest: its line has been sent by then.
    """

    kind: str
    words: tuple[str, ...]
    after_ms: tuple[float, float]
    place: str = ""
    pc: int | None = None


ENDS = {
    "bad-hardfault-loop": End(
        "fault-loop",
        ("over and over", "escalated to HardFault", "PRECISERR", "0x60000000"),
        (1.3, 10),
        place="read_from_nowhere (hardfault-loop.c:10)",
    ),
    "bad-iwdg-loop": End(
        "reset-loop", ("8 resets", "independent watchdog"), (195, 205), place="forget_to_feed (iwdg-loop.c:10)"
    ),
    "bad-jump-erased": End(
        "fault-loop", ("erased", "UNDEFINSTR", "call_application (jump-erased.c"), (1.1, 3), pc=0x0800_F000
    ),
    "bad-lockup": End(
        "lockup", ("UNDEFINSTR", "PRECISERR", "0x60000004", "in HardFault"), (0.6, 1), "HardFault_Handler (lockup.c:8)"
    ),
    "bad-runaway-nowhere": End("fault-loop", ("IBUSERR", "call_nowhere (runaway-nowhere.c"), (1.4, 4), pc=0x3000_0000),
    "bad-runaway-ram": End("fault-loop", ("UNDEFINSTR", "call_junk (runaway-ram.c"), (1.1, 4), pc=0x2000_4800),
    "bad-stack-overflow": End("fault-loop", ("STKERR",), (1.3, 4), place="recurse (stack-overflow.c:13)"),
}


def test_all_are_run():
    assert sorted([*ENDS, "bad-stuck"]) == [name for name in image_names() if name.startswith("bad-")]


@pytest.mark.parametrize("timing", ["flat", pytest.param("table", marks=OTHER_TIMING)])
@pytest.mark.parametrize("name", ENDS)
def test_how_it_ends(start, name, timing):
    run = start(name, timing=timing).to(LIMIT_MS)
    ended, expected = run.machine.ended, ENDS[name]
    assert ended.kind == expected.kind
    assert ended.status == 1
    assert ended.place == expected.place
    assert expected.pc in (None, ended.pc)
    missing = [word for word in expected.words if word not in ended.cause]
    assert not missing, ended.cause
    earliest, latest = expected.after_ms
    assert earliest * 1e6 <= ended.ns <= latest * 1e6
    line = f"{name.removeprefix('bad-')}\r\n".encode()
    assert run.sent["USART1"] == line * max(1, run.resets.count("IWDG"))


@pytest.mark.exhaustive("each in other ways; the gate has such images in two ways each in traces/test_goldens.py")
@pytest.mark.parametrize("name", [*ENDS, "bad-stuck"])
def test_it_ends_at_the_same_cycle_however_it_is_run(start, name):
    def end(step_ns=None, **options):
        run = start(name, **options).to(LIMIT_MS if name in ENDS else 20, step_ns=step_ns)
        return run.machine.ended, run.sent, run.resets, run.machine.chip.pins["PC13"].level

    assert end() == end(step_ns=77_777) == end(step_ns=1_000_000, skip_idle=False)


@each("timing", ["flat", "table"])
def test_a_wait_for_what_never_comes_does_not_end_but_is_seen(start, timing):
    run = start("bad-stuck", timing=timing).to(2000)
    assert run.machine.ended is None
    assert run.sent["USART1"] == b"stuck\r\n"
    waits = run.machine.waits_in
    assert run.machine.place(waits.pc).startswith("wait_for_update (stuck.c")
    assert waits.polled == (0x4000_0010,)  # TIM2_SR


def test_the_led_is_lit_before_anything_goes_wrong(start):
    for name in ENDS:
        run = start(name).to(LIMIT_MS)
        assert run.machine.chip.pins["PC13"].level is False or "IWDG" in run.resets
