"""`hilbench run --break` and `--watch`: the run ends before an instruction."""

from __future__ import annotations

import contextlib
import json

from hilbench.cli import main
from hilbench.mcu.command_line import open_target
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.stops import set_stops
from tests.hilbench.mcu.test_init_and_fixtures import IMAGES

KERNEL = f"bluepill:{IMAGES / 'style-kernel.elf'}"


def ran(capsys, *options):
    status = main(["run", KERNEL, "--for", "50ms", "--json", *options])
    return status, json.loads(capsys.readouterr().out)


def test_it_ends_before_a_function(capsys):
    status, told = ran(capsys, "--break", "main")
    end = told["end"]
    assert (status, end["kind"], end["cause"], end["place"].partition(" ")[0]) == (0, "stop", "a breakpoint", "main")
    assert told["bench_time_s"] < 0.05
    status, by_address = ran(capsys, "--break", hex(end["pc"]))
    assert (status, by_address["end"]) == (0, end)


def test_it_ends_before_a_write(capsys):
    status, told = ran(capsys, "--watch", "0x40010800", "--watch", "0x40010804")
    assert (status, told["end"]["kind"]) == (0, "stop")
    assert told["end"]["cause"].startswith("about to write 0x")
    assert told["end"]["cause"].endswith(" to 0x40010800")


def test_a_place_that_is_not_reached_changes_nothing(capsys):
    before, after = (ran(capsys, *options)[1] for options in ((), ("--break", "0x08000000", "--watch", "0x40002800")))
    for told in (before, after):
        del told["real_time_factor"]
    assert before == after
    assert before["end"] is None


def test_all_places_of_a_name_count():
    """Two files of the firmware have a static function `send`."""
    emulated = EmulatedBench(open_target(f"bluepill:{IMAGES / 'robot-dodge-p2os.elf'}"))
    with contextlib.closing(emulated):
        set_stops(emulated, ["send"], ["send"])
        (machine,) = emulated.machines.values()
        hooks = machine.engine.hooks
        assert len(hooks.breakpoints) == 2
        assert {one.address & ~1 for one in hooks.watchpoints} == hooks.breakpoints


def test_the_text_says_where(capsys):
    assert main(["run", KERNEL, "--for", "50ms", "--break", "main"]) == 0
    assert "board: stop in main (" in capsys.readouterr().err.replace("bluepill:", "board:")


def test_a_symbol_that_is_not_there_is_refused(capsys):
    assert main(["run", KERNEL, "--for", "1ms", "--break", "mian"]) == 2
    said = capsys.readouterr().err
    assert "no image has a symbol 'mian'" in said
    assert "did you mean 'main'?" in said
    assert main(["run", KERNEL, "--for", "1ms", "--watch", "0x123456789"]) == 2
    assert "is no address of 32 bits" in capsys.readouterr().err
