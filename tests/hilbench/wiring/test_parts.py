"""Parts on a bench: when they are called, in which order, and where what they do goes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import pytest

from hilbench.benchfile.bench_file import Net, PartPlan, PinEnd, TerminalEnd
from hilbench.links import Line, MemoryLink
from hilbench.mcu import parts as wiring
from hilbench.mcu.parts import Parts
from targets.parts import Control, Direction, Part, Quantity, Terminal
from targets.parts.joystick import JoystickSettings
from targets.parts.part import check_controls

MS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    period_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Happened:
    what: str


class Probe(Part):
    """Writes down how it is called."""

    TERMINALS = (
        Terminal(name="in1", direction=Direction.IN),
        Terminal(name="in2", direction=Direction.IN),
        Terminal(name="out", direction=Direction.OUT),
        Terminal(name="free", direction=Direction.OUT),
    )
    QUANTITIES = (
        Quantity(name="angle", direction=Direction.IN, unit="rad", needed=False),
        Quantity(name="speed", direction=Direction.OUT, unit="m/s", needed=False),
    )
    SERIAL = ("uart",)
    CONTROLS = (Control(name="stick", least=-1, greatest=1),)
    Settings = Settings

    def __init__(self, settings, ports, *, seed):
        self.settings, self.ports, self.seed = settings, ports, seed
        self.calls = []
        self.due_ns = None
        self.speed = 0.0

    def power_on(self, now_ns):
        self.calls.append(("power_on", now_ns))
        self.ports.output("out").set(False, now_ns)
        if self.settings.period_ns:
            self.due_ns = now_ns + self.settings.period_ns

    def advance(self, now_ns):
        self.calls.append(("advance", now_ns))
        self.due_ns = now_ns + self.settings.period_ns if self.settings.period_ns else None
        self.ports.tell(Happened(what="advance"))

    def next_deadline_ns(self):
        return self.due_ns

    def receive(self, data, now_ns):
        self.calls.append(("receive", now_ns, data))
        self.due_ns = now_ns + 2 * MS

    def before_step(self, from_ns, to_ns):
        self.calls.append(("before_step", from_ns, to_ns))
        return {"speed": self.speed}

    def after_step(self, from_ns, to_ns, before, after):
        self.calls.append(("after_step", from_ns, to_ns, dict(before), dict(after)))
        self.ports.output("out").set(True, to_ns)

    def set(self, values, now_ns):
        check_controls(self.CONTROLS, values)
        self.calls.append(("set", now_ns, dict(values)))
        self.due_ns = now_ns + MS


class FakeRunner:
    def __init__(self):
        self.before, self.after = [], []

    def step(self, now_ns, next_ns):
        for act in (*self.before, *self.after):
            act(now_ns, next_ns)


class FakeSignals:
    """Stands for the signals of a world."""

    def __init__(self, _body, wanted):
        self.wanted = wanted
        self.values = dict.fromkeys(wanted, 0.0)
        self.driven = []
        FakeSignals.made = self

    def read(self):
        return dict(self.values)

    def drive(self, name, value):
        self.driven.append((name, value))


def terminal(part, name):
    return TerminalEnd(part=part, terminal=name)


def on_pin(pin, *terminals, supplies=()):
    pins = (PinEnd(board="brain", pin=pin),) if pin else ()
    return Net(pins=pins, terminals=terminals, supplies=frozenset(supplies))


@pytest.fixture
def make(bench, machine, monkeypatch):
    """Make parts of the kind above, by name; the chip has pins PA0 and PA1."""
    monkeypatch.setattr(wiring, "part_class", lambda _kind: Probe)
    chip = machine(PA0=False, PA1=None)

    def build(nets=(), seed=1, **settings):
        plans = {
            name: PartPlan(kind="probe", settings=one, signals={"angle": "wheel_left_angle", "speed": f"{name}_speed"})
            for name, one in (settings or {"one": Settings()}).items()
        }
        parts = Parts(bench, plans, {"brain": chip}, nets, seed=seed)
        parts.chip = chip
        return parts

    return build


def calls(parts, name="one", kind=None):
    return [call for call in parts.by_name[name].calls if kind in {None, call[0]}]


def test_power_comes_first_and_then_what_is_due(make, bench):
    parts = make(one=Settings(period_ns=3 * MS))
    assert calls(parts) == []
    parts.power_on()
    bench.run_for(0.010)
    assert calls(parts) == [("power_on", 0), *(("advance", time * MS) for time in (3, 6, 9))]


def test_parts_that_are_due_at_once_are_called_in_the_order_of_their_names(make, bench):
    parts = make(two=Settings(period_ns=MS), one=Settings(period_ns=MS))
    order = []
    parts.taps.append(lambda name, _event: order.append(name))
    parts.power_on()
    bench.run_for(0.002)
    assert order == ["one", "two", "one", "two"]


def test_a_deadline_that_moves_is_the_only_one(make, bench):
    parts = make()
    parts.power_on()
    part = parts.by_name["one"]
    part.due_ns = 5 * MS
    parts.settle("one")
    part.due_ns = 3 * MS
    parts.settle("one")
    part.settings = Settings(period_ns=100 * MS)
    bench.run_for(0.010)
    assert calls(parts, kind="advance") == [("advance", 3 * MS)]


def test_a_deadline_that_falls_away_is_none(make, bench):
    parts = make(one=Settings(period_ns=2 * MS))
    parts.power_on()
    parts.by_name["one"].due_ns = None
    parts.settle("one")
    bench.run_for(0.010)
    assert calls(parts, kind="advance") == []


def test_a_deadline_in_the_past_is_now(make, bench):
    parts = make()
    parts.power_on()
    bench.run_for(0.005)
    part = parts.by_name["one"]
    part.due_ns, part.settings = 2 * MS, Settings(period_ns=100 * MS)
    parts.settle("one")
    bench.run_for(0.001)
    assert calls(parts, kind="advance") == [("advance", 5 * MS)]


def test_events_go_to_the_journal_and_to_the_taps(make, bench):
    parts = make(one=Settings(period_ns=MS))
    told = []
    parts.taps.append(lambda name, event: told.append((name, event)))
    parts.power_on()
    bench.run_for(0.001)
    assert told == [("one", Happened(what="advance"))]
    (event,) = [event for event in bench.journal.recent if event["source"] == "one"]
    assert (event["kind"], event["name"], event["value"]) == ("event", "Happened", {"what": "advance"})


def test_the_seed_of_each_part_is_its_own_and_follows_from_the_seed_of_the_run(make):
    parts, again, other = (make(seed=seed, one=Settings(), two=Settings()) for seed in (1, 1, 2))
    seeds = [parts.by_name[name].seed for name in ("one", "two")]
    assert len(set(seeds)) == 2
    assert seeds == [again.by_name[name].seed for name in ("one", "two")]
    assert seeds[0] != other.by_name["one"].seed


# --- wires


def test_an_input_hears_its_pin_and_what_a_supply_holds(make):
    parts = make([on_pin("PA0", terminal("one", "in1")), on_pin("", terminal("one", "in2"), supplies=["3v3"])])
    ports = parts.by_name["one"].ports
    parts.chip.chip.pins["PA0"].edge(0, True)
    assert ports.input("in1").level_at(0)
    held = ports.input("in2")
    assert (held.level(), held.level_at(5), held.mean(0, 9), held.latch()) == (True, True, 1.0, True)


def test_an_output_drives_its_pin_and_what_it_drives_can_be_asked_for(make):
    parts = make([on_pin("PA1", terminal("one", "out"))])
    assert parts.driven("one", "out") is None
    parts.power_on()
    parts.chip.run()
    assert parts.chip.chip.pins["PA1"].driven == [False]
    assert parts.driven("one", "out") is False


def test_what_an_open_output_drives_can_be_asked_for_too(make):
    parts = make()
    assert parts.driven("one", "free") is None
    parts.by_name["one"].ports.output("free").set(True, 0)
    assert parts.driven("one", "free") is True
    with pytest.raises(KeyError):
        parts.driven("one", "in1")


# --- lines and controls


def test_bytes_go_both_ways_and_into_the_journal(make, bench):
    parts = make()
    link = MemoryLink(bench.scheduler, Line(baud=9600), name="line")
    heard = []
    link.b.on_receive = lambda data, at_ns: heard.append((data, at_ns))
    parts.attach("one", link.a)
    parts.power_on()
    parts.by_name["one"].ports.serial(b"\x55")
    link.b.write(b"\xaa")
    bench.run_for(0.010)
    frame_ns = heard[0][1]
    assert heard[0][0] == b"\x55"
    assert frame_ns == pytest.approx(10 / 9600 * 1e9, rel=0.01)
    assert [call[2] for call in calls(parts, kind="receive")] == [b"\xaa"]
    received_ns = calls(parts, kind="receive")[0][1]
    assert calls(parts, kind="advance")[0] == ("advance", received_ns + 2 * MS)
    lines = [
        (event["kind"], event["data"]) for event in bench.journal.recent if event["source"] == "one" and "data" in event
    ]
    assert lines == [("tx", "55"), ("rx", "aa")]


def test_a_part_without_a_line_may_speak_into_the_void(make):
    parts = make()
    parts.power_on()
    parts.by_name["one"].ports.serial(b"\x55")


def test_controls_are_moved_now_and_the_part_called_when_it_then_wants(make, bench):
    parts = make()
    parts.power_on()
    bench.run_for(0.004)
    parts.set("one", {"stick": 0.5})
    bench.run_for(0.002)
    assert calls(parts)[1:3] == [("set", 4 * MS, {"stick": 0.5}), ("advance", 5 * MS)]
    with pytest.raises(ValueError, match="stick goes from -1 to 1"):
        parts.set("one", {"stick": 2})


# --- the world's steps


def test_before_and_after_each_step(make, bench):
    parts, runner = make(one=Settings(), two=Settings()), FakeRunner()
    parts.join(runner, partial(FakeSignals, None))
    parts.power_on()
    signals = FakeSignals.made
    assert signals.wanted == ["wheel_left_angle"]
    parts.by_name["two"].speed = 0.25
    signals.values["wheel_left_angle"] = 1.5
    runner.step(10, 20)
    assert signals.driven == [("one_speed", 0.0), ("two_speed", 0.25)]
    assert calls(parts)[1:] == [
        ("before_step", 10, 20),
        ("after_step", 10, 20, {"angle": 0.0}, {"angle": 1.5}),
    ]
    signals.values["wheel_left_angle"] = 2.0
    runner.step(20, 30)
    assert calls(parts, "two")[-1] == ("after_step", 20, 30, {"angle": 1.5}, {"angle": 2.0})


def test_what_goes_out_and_is_not_wired_is_left_out(bench, machine, monkeypatch):
    monkeypatch.setattr(wiring, "part_class", lambda _kind: Probe)
    plans = {"one": PartPlan(kind="probe", settings=Settings(), signals={"angle": "wheel_left_angle"})}
    parts, runner = Parts(bench, plans, {"brain": machine()}, [], seed=1), FakeRunner()
    parts.join(runner, partial(FakeSignals, None))
    parts.power_on()
    runner.step(10, 20)
    assert FakeSignals.made.driven == []


def test_a_test_may_show_something_else_than_the_world(make, bench):
    parts, runner = make(), FakeRunner()
    parts.join(runner, partial(FakeSignals, None))
    parts.power_on()
    parts.senses = False
    runner.step(10, 20)
    assert calls(parts, kind="after_step") == []
    bench.run_for(0.001)
    parts.show("one", {"angle": 3.0})
    assert calls(parts)[-1] == ("after_step", MS, MS, {"angle": 3.0}, {"angle": 3.0})
    parts.senses = True
    FakeSignals.made.values["wheel_left_angle"] = 4.0
    runner.step(20, 30)
    assert calls(parts)[-1][3:] == ({"angle": 0.0}, {"angle": 4.0})


def test_an_analog_terminal_puts_its_voltage_on_a_pin(bench, machine):
    board = machine(PA0=None, PA1=None, PA2=None)
    net = partial(_joystick_net, board="brain")
    parts = Parts(
        bench,
        {"stick": PartPlan(kind="joystick", settings=JoystickSettings(bounce_ms=0.0))},
        {"brain": board},
        [net("vrx", "PA0"), net("vry", "PA1"), net("sw", "PA2")],
        seed=1,
    )
    parts.power_on()
    parts.set("stick", {"x": 1.0, "press": 1})
    board.run()
    assert board.chip.pins["PA0"].volts == [pytest.approx(33970 / 65536 * 3.3), pytest.approx(3.3, abs=1e-4)]
    assert board.chip.pins["PA1"].volts == [pytest.approx(33580 / 65536 * 3.3)]
    assert board.chip.pins["PA2"].driven == [False]


def test_the_voltages_at_pins_are_told_by_pin_at_each_end_of_their_wires(bench, machine):
    boards = {"brain": machine(PA0=None, PA1=None, PA2=None), "other": machine(PB0=None)}
    net = partial(_joystick_net, board="brain")
    both = Net(pins=(*net("vrx", "PA0").pins, PinEnd(board="other", pin="PB0")), terminals=net("vrx", "PA0").terminals)
    plans = {"stick": PartPlan(kind="joystick", settings=JoystickSettings())}
    parts = Parts(bench, plans, boards, [both, net("vry", "PA1"), net("sw", "PA2")], seed=1)
    assert parts.volts() == {}
    parts.power_on()
    x_v, y_v = (pytest.approx(zero / 65536 * 3.3) for zero in (33970, 33580))
    assert parts.volts() == {"brain.PA0": x_v, "other.PB0": x_v, "brain.PA1": y_v}
    parts.set("stick", {"x": 1.0})
    assert parts.volts()["other.PB0"] == pytest.approx(3.3, abs=1e-4)


def _joystick_net(terminal, pin, *, board):
    return Net(pins=(PinEnd(board=board, pin=pin),), terminals=(TerminalEnd(part="stick", terminal=terminal),))
