"""Edges of serial lines: told as bytes to people and in the journal, as edges in waveforms and where asked for."""

from __future__ import annotations

import io
import itertools
from pathlib import Path

import pytest
from vcd.reader import TokenKind, tokenize

from hilbench.clock import NS_PER_MS
from hilbench.journal import Journal
from hilbench.mcu.command_line import open_target
from hilbench.mcu.emulated import EmulatedBench
from hilbench.serving.run import RunOptions, run
from hilbench.terminal.console import Console
from targets.mcu.pins import Pin

IMAGES = Path(__file__).parents[3] / "targets/firmware/images"


@pytest.fixture
def followed():
    """Run an image; return the lines it is told by, without time, as (who, what)."""

    def go(image, for_ms, **options):
        out = io.StringIO()
        options = RunOptions(for_ns=for_ms * NS_PER_MS, follow=True, **options)
        run(options, open_target(f"bluepill:{IMAGES / image}.elf"), Console(out, io.StringIO()))
        return [tuple(line.split(maxsplit=2)[1:]) for line in out.getvalue().splitlines()]

    return go


def test_a_line_is_told_by_its_bytes(followed):
    lines = followed("style-hal", 6)
    assert [line for line in lines if line[0] in {"bluepill.PA2", "bluepill.usart2"}] == [
        ("bluepill.PA2", "high"),  # the transmitter takes the pin
        ("bluepill.usart2", "> style-hal at 72000000 Hz"),
    ]


def test_the_edges_of_a_line_can_be_had(followed):
    lines = followed("style-hal", 6, edges=True)
    assert len([line for line in lines if line[0] == "bluepill.PA2"]) == 20  # so many of a pin that is fast
    assert ("bluepill.usart2", "> style-hal at 72000000 Hz") in lines


def test_a_reset_that_cuts_a_frame_shows_at_the_pin(followed):
    lines = followed("bad-iwdg-loop", 30)
    assert lines.count(("bluepill.PA9", "floats")) == 1
    assert lines.count(("bluepill.PA9", "high")) == 2


def test_a_line_without_rest_is_no_fast_pin(tmp_path):
    """It sends for whole windows of the log, and is looked at for only a part of the time."""
    emulated = EmulatedBench(open_target(f"bluepill:{IMAGES / 'echo-irq.elf'}"), journal=tmp_path / "j")
    emulated.bench.run_for(0.01)
    emulated.ports["bluepill.usart1"].write(bytes(range(256)) * 10)
    emulated.bench.run_for(0.3)
    emulated.close()
    events = Journal.read(tmp_path / "j").events
    assert [event["kind"] for event in events if event["source"] == "bluepill.PA9"] == ["pin"]
    assert sum(len(event["data"]) // 2 for event in events if event["kind"] == "tx") == 256 * 10


@pytest.mark.parametrize(("options", "made"), [({}, False), ({"edges_of_frames": True}, True)])
def test_edges_that_nobody_wants_are_not_made(monkeypatch, options, made):
    """But for those of a frame under way at the end of a window of the log."""
    edges = []
    keep = Pin._keep_edge
    monkeypatch.setattr(Pin, "_keep_edge", lambda pin, edge: edges.append(pin.name) or keep(pin, edge))
    emulated = EmulatedBench(open_target(f"bluepill:{IMAGES / 'echo-irq.elf'}"), **options)
    emulated.bench.run_for(0.01)
    emulated.ports["bluepill.usart1"].write(b"U" * 100)
    emulated.bench.run_for(0.05)
    emulated.close()
    assert (edges.count("PA9") >= 10 * 100) is made
    assert (edges.count("PA9") <= 1) is not made


def test_what_is_told_of_a_line_does_not_depend_on_the_step(tmp_path):
    def journal(step_ns):
        file = tmp_path / str(step_ns)
        emulated = EmulatedBench(
            open_target(f"bluepill:{IMAGES / 'echo-irq.elf'}"), journal=file, step_ns=step_ns * NS_PER_MS // 10
        )
        port = emulated.ports["bluepill.usart1"]
        emulated.bench.run_for(0.01)
        port.write(bytes(range(200)))
        emulated.bench.run_for(0.25)
        emulated.close()
        return [event for event in Journal.read(file).events if event["kind"] in {"pin", "pwm", "tx"}]

    first, *others = [journal(step_ns) for step_ns in (1, 7, 100, 2500)]
    assert [other == first for other in others] == [True] * 3
    assert sum(event["source"] == "bluepill.PA9" for event in first) == 1
    assert sum(event["source"] == "bluepill.PC13" for event in first) > 20


@pytest.mark.parametrize(("lockstep_us", "notes"), [(20, ["one.PA9.USART1_TX", "two.PA9.USART1_TX"]), (2, [])])
def test_a_line_made_of_wires_needs_a_short_lockstep(tmp_path, lockstep_us, notes):
    boards = {"one": "style-irq-dma", "two": "echo-irq"}
    targets = [
        f'[targets.{name}]\nboard = "bluepill"\nfirmware = "{IMAGES / image}.elf"\n' for name, image in boards.items()
    ]
    wires = ['[[wires]]\nends = ["one.PA9", "two.PA10"]\n', '[[wires]]\nends = ["one.PA10", "two.PA9"]\n']
    file = tmp_path / "wired.toml"
    file.write_text("".join([f"version = 1\nlockstep_us = {lockstep_us}\n", *targets, *wires]))
    emulated = EmulatedBench(open_target(str(file)))
    said = bytearray()
    emulated.ports["one.usart1"].taps.append(lambda data, _at_ns: said.extend(data))
    emulated.bench.run_for(0.01)
    emulated.close()
    wired = [note for note in emulated.notes() if "[[links]]" in note["text"]]
    assert sorted(f"{note['board']}.{note['where']}" for note in wired) == notes
    # the second board sends back what it heard, and the first answers to that
    assert said.startswith(b"style-irq-dma\r\n? style-irq-dma\r\n") is not bool(notes)


# --- as a reader of waveforms sees them


def read_waves(file):
    """Return the timescale in ns, and for each signal its changes as (ns, level)."""
    scope, names, changes, ns = [], {}, {}, 0
    timescale = None
    for token in tokenize(file):
        match token.kind:
            case TokenKind.TIMESCALE:
                timescale = (token.timescale.magnitude, token.timescale.unit.value)
            case TokenKind.SCOPE:
                scope.append(token.scope.ident)
            case TokenKind.UPSCOPE:
                scope.pop()
            case TokenKind.VAR:
                names.setdefault(token.var.id_code, []).append(".".join([*scope, token.var.reference]))
            case TokenKind.CHANGE_TIME:
                ns = token.time_change
            case TokenKind.CHANGE_SCALAR:
                for name in names[token.scalar_change.id_code]:
                    changes.setdefault(name, []).append((ns, token.scalar_change.value))
    return timescale, changes


def test_waveforms_have_every_edge_of_the_journal_at_its_time(tmp_path):
    emulated = EmulatedBench(
        open_target(f"bluepill:{IMAGES / 'style-hal.elf'}"),
        journal=tmp_path / "j",
        vcd=tmp_path / "w.vcd",
        edges_of_frames=True,
    )
    emulated.bench.run_for(0.12)
    emulated.close()
    with (tmp_path / "w.vcd").open("rb") as file:
        timescale, changes = read_waves(file)
    assert timescale == (1, "ns")
    told = [event for event in Journal.read(tmp_path / "j").events if event["kind"] == "pin"]
    assert {event["source"] for event in told} >= {f"bluepill.{pin}" for pin in ("PA2", "PB0", "PC13", "PA6")}
    for event in told:
        board, pin = event["source"].split(".")
        level = {True: "1", False: "0", None: "z"}[event["level"]]
        assert (event["ns"], level) in changes[f"{board}.pins.{pin}"], event


def test_pin_and_line_show_the_same_edges(tmp_path):
    """PA2 carries TX of USART2: its edges are those of the frames."""
    emulated = EmulatedBench(open_target(f"bluepill:{IMAGES / 'style-hal.elf'}"), vcd=tmp_path / "w.vcd")
    emulated.bench.run_for(0.12)
    emulated.close()
    with (tmp_path / "w.vcd").open("rb") as file:
        _, changes = read_waves(file)
    pin = [change for change in changes["bluepill.pins.PA2"] if change[1] != "z"]
    line = changes["bluepill.usart2.tx"]
    assert pin[1:] == line[1:]  # each begins with a level
    assert len(line) > 100
    for changed in changes.values():
        assert all(before[0] < after[0] and before[1] != after[1] for before, after in itertools.pairwise(changed))
