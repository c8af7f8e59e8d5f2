"""Bench files with a rover: what they mean, what is refused, and a whole drive train of parts without firmware."""

from __future__ import annotations

import contextlib
import math
import re
from pathlib import Path

import pytest

from hilbench.benchfile.bench_file import QuantityEnd
from hilbench.errors import HilbenchError
from hilbench.mcu.surroundings import Surroundings
from targets.parts.l298n import L298nOverload
from worlds.vehicles.rover_4wd import Rover4wdBody

DOCS = Path(__file__).parents[4] / "docs" / "rover-vehicle.md"
MS = 1_000_000
WHEELS = ("lf", "rf", "lb", "rb")

HEAD = """version = 1
[targets.brain]
board = "bluepill"
firmware = "a.elf"
[world]
vehicle = "rover-4wd"
scene = "{}"
"""
DRIVER = """[parts.cells]
kind = "battery"
signals = {{ current = "driver.current" }}
[parts.driver]
kind = "l298n"
pins = {{ ena = "{ena}", in1 = "{in1}", in2 = "{in2}", in3 = "{in3}", in4 = "{in4}", enb = "{enb}" }}
[parts.driver.signals]
supply = "cells.emf"
source = "cells.resistance"
load_a1 = "motor_lf.current"
load_a2 = "motor_lb.current"
load_b1 = "motor_rf.current"
load_b2 = "motor_rb.current"
"""
MOTOR = """[parts.motor_{0}]
kind = "dc-motor"
[parts.motor_{0}.signals]
volts = "driver.out_{1}"
closed = "driver.closed_{1}"
speed = "world.wheel_{0}_speed"
torque = "world.wheel_{0}_torque"
friction = "world.wheel_{0}_friction"
"""
TACHO = """[parts.tacho_{0}]
kind = "tachometer-disc"
pins = {{ out = "brain.{1}" }}
signals = {{ angle = "world.wheel_{0}_angle" }}
"""
FORWARD = {"ena": "3v3", "in1": "3v3", "in2": "gnd", "in3": "3v3", "in4": "gnd", "enb": "3v3"}


def text(scene="stand", **levels):
    motors = "".join(MOTOR.format(wheel, "a" if wheel.startswith("l") else "b") for wheel in WHEELS)
    tachos = "".join(TACHO.format(wheel, f"PB{pin}") for wheel, pin in zip(WHEELS, (3, 4, 5, 6), strict=True))
    return HEAD.format(scene) + DRIVER.format(**FORWARD | levels) + motors + tachos


@pytest.fixture
def rover(bench, read, machine):
    """A rover with everything but a program; `pins` are the board's."""
    with contextlib.ExitStack() as opened:

        def make(scene="stand", **levels):
            board = machine(PA0=False, PA1=False, PB3=None, PB4=None, PB5=None, PB6=None)
            made = Surroundings(bench, read(text(scene, **levels)), None, {"brain": board}, {}, seed=1)
            opened.callback(made.close)
            made.pins, made.board = board.chip.pins, board
            return made

        yield make


def rpm(made, wheel="lf"):
    return made.body.wheel(f"wheel_{wheel}").speed_rad_s * 60 / math.tau


def pulse(made, pin, duty, from_s, to_s, period_ns=20 * MS):
    """Pulses on a pin, as a chip makes them that has run ahead."""
    for start_ns in range(round(from_s * 1e9), round(to_s * 1e9), period_ns):
        made.pins[pin].edge(start_ns, True)
        made.pins[pin].edge(start_ns + round(duty * period_ns), False)


# --- what a file means


def test_a_quantity_may_come_from_another_part(read):
    parts = read(text()).parts
    assert parts["motor_lf"].sources == {
        "volts": QuantityEnd(part="driver", quantity="out_a"),
        "closed": QuantityEnd(part="driver", quantity="closed_a"),
    }
    assert parts["motor_rb"].signals == {
        "speed": "wheel_rb_speed",
        "torque": "wheel_rb_torque",
        "friction": "wheel_rb_friction",
    }
    assert parts["cells"].sources == {"current": QuantityEnd(part="driver", quantity="current")}


WRONG = {
    "no such quantity of a part": (
        '"driver.out_a"',
        '"driver.out_c"',
        "'driver' has no quantity 'out_c'; did you mean",
    ),
    "what the other part takes": (
        '"driver.out_a"',
        '"driver.supply"',
        "'driver.supply' is what 'driver' takes; it can be",
    ),
    "another unit": (
        '"driver.out_a"',
        '"driver.closed_a"',
        "'driver.closed_a' is in 1, and this in V; it can be cells.emf",
    ),
    "no such part": ('"driver.out_a"', '"drivr.out_a"', "no signal 'drivr.out_a'; it can be cells.emf"),
    "no such signal": (
        '"world.wheel_lf_torque"',
        '"world.wheel_fr_torque"',
        "no signal 'world.wheel_fr_torque'; did you mean 'world.wheel_rf_torque'?",
    ),
    "a signal of another vehicle": (
        '"world.wheel_lf_speed"',
        '"world.wheel_left_angle"',
        "no signal 'world.wheel_left_angle'; did you mean 'world.wheel_lf_angle'?",
    ),
    "two motors on a wheel": (
        '"world.wheel_lb_torque"',
        '"world.wheel_lf_torque"',
        "world.wheel_lf_torque is driven by 'motor_lf' already",
    ),
    "what goes out leads to a part": (
        '"world.wheel_lf_torque"',
        '"driver.supply"',
        "'torque' goes out, and 'driver.supply' is no signal of the world; write under [parts.driver] where",
    ),
    "a motor without its driver": ('closed = "driver.closed_a"\n', "", "its quantity 'closed'"),
    "a physics without torques": (
        'scene = "stand"',
        'scene = "empty"\nphysics = "plane"',
        'physics "plane" has vehicles with two wheels, and no rover-4wd; leave out physics = "plane"',
    ),
    "a terminal that is open": (', enb = "3v3" }', " }", "'driver': its terminal 'enb' (enables channel B) is open"),
}


@pytest.mark.parametrize("mistake", WRONG)
def test_mistakes_are_named_with_what_would_be_right(read, mistake):
    right, wrong, message = WRONG[mistake]
    assert right in text()
    with pytest.raises(HilbenchError) as caught:
        read(text().replace(right, wrong, 1))
    assert message in str(caught.value)


def test_parts_that_wait_for_each_other_are_refused(read):
    """The battery takes its current late; a driver that took its supply from itself by way of a motor would not."""
    circle = text().replace('supply = "cells.emf"', 'supply = "driver.out_a"', 1)
    with pytest.raises(HilbenchError, match=r"driver -> driver: each needs for a step what the next one gives"):
        read(circle)


def test_the_bench_in_the_docs_is_right(read):
    """The page has one motor and one disc, and says how the others differ."""
    (page,) = re.findall(r"```toml\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    motor = page[page.index("[parts.motor_lf]") : page.index("[parts.tacho_lf]")]
    disc = page[page.index("[parts.tacho_lf]") :]
    for wheel, channel, pin in (("rf", "b", "PE8"), ("lb", "a", "PG9"), ("rb", "b", "PG14")):
        page += motor.replace("_lf", f"_{wheel}").replace('_a"', f'_{channel}"')
        assert f"{wheel} on {pin}" in disc
        page += disc.replace("_lf", f"_{wheel}").replace("PE7", pin)
    bench = read(HEAD.partition("[world]")[0].replace("bluepill", "nucleo-f767zi") + page)
    assert len(bench.parts) == 10
    assert {pin.pin for net in bench.nets for pin in net.pins} >= {"PB11", "PE10", "PE7", "PG14"}


# --- a drive train, alive


@pytest.mark.needs_physics
def test_held_inputs_turn_all_wheels_at_full_speed(rover, bench):
    """Two full cells less what driver and battery take at 0.3 A a channel: 197 rpm with the gears' friction."""
    made = rover()
    assert isinstance(made.body, Rover4wdBody)
    bench.run_for(1.5)
    assert [rpm(made, wheel) for wheel in WHEELS] == pytest.approx([197.5] * 4, rel=0.01)
    before = made.parts.by_name["cells"].charge
    bench.run_for(1.0)
    drawn_a = (before - made.parts.by_name["cells"].charge) * 2.6 * 3600
    assert drawn_a == pytest.approx(4 * 0.154 + 0.05, rel=0.03)


@pytest.mark.needs_physics
@pytest.mark.parametrize(
    ("levels", "left", "right"),
    [
        ({"in1": "gnd", "in2": "3v3"}, -1, 1),
        ({"in3": "gnd", "in4": "3v3"}, 1, -1),
        ({"ena": "gnd"}, 0, 1),
        ({"in2": "3v3"}, 0, 1),
        ({"in3": "gnd", "in4": "3v3", "in1": "gnd", "in2": "3v3"}, -1, -1),
    ],
)
def test_each_side_follows_its_own_inputs(rover, bench, levels, left, right):
    made = rover(**levels)
    bench.run_for(0.5)
    for wheel in WHEELS:
        wanted = left if wheel.startswith("l") else right
        assert round(rpm(made, wheel) / 190) == wanted


@pytest.mark.needs_physics
@pytest.mark.parametrize(("throttle", "speed_rpm"), [(0.25, 95), (0.30, 117.5), (0.39, 143.5)])
def test_slow_pulses_of_a_chip_give_the_speeds_of_the_original(rover, bench, throttle, speed_rpm):
    made = rover(ena="brain.PA0", enb="brain.PA0")
    pulse(made, "PA0", 0.9, 0.0, 0.2)
    pulse(made, "PA0", throttle, 0.2, 2.6)
    bench.run_for(2.4)
    mean = 0.0
    for _ in range(48):
        bench.run_for(1 / 240)
        mean += rpm(made) / 48
    assert mean == pytest.approx(speed_rpm, abs=3)
    assert rpm(made, "rb") == pytest.approx(rpm(made), rel=1e-3)


@pytest.mark.needs_physics
def test_shorted_motors_stop_at_once_and_open_ones_run_out(rover, bench):
    stops = {}
    for name, last in (("coast", (False, False)), ("brake", (True, True))):
        made = rover(ena="brain.PA0", in2="brain.PA1")
        start_ns = bench.now_ns
        made.pins["PA0"].edge(start_ns, True)
        bench.run_for(0.5)
        top = rpm(made)
        made.pins["PA0"].edge(bench.now_ns, last[0])
        made.pins["PA1"].edge(bench.now_ns, last[1])
        bench.run_for(0.1)
        stops[name] = rpm(made) / top
    assert stops["brake"] < 0.4 < 0.8 < stops["coast"]


@pytest.mark.needs_physics
def test_a_hand_on_a_wheel_stalls_its_motor(rover, bench):
    made = rover()
    told = []
    made.parts.taps.append(lambda name, event: told.append((name, event)))
    made.parts.set("motor_lf", {"hold": 1})
    made.parts.set("motor_lb", {"hold": 1})
    bench.run_for(1.0)
    assert rpm(made, "lf") == pytest.approx(0.0, abs=1e-3)
    assert rpm(made, "rf") > 180
    assert [event.channel for _, event in told if isinstance(event, L298nOverload)] == ["a"]
    made.parts.set("motor_lf", {"hold": 0})
    bench.run_for(1.0)
    assert rpm(made, "lf") > 140  # the other one still draws what a stalled motor draws


@pytest.mark.needs_physics
def test_tachometers_put_their_slots_on_the_pins(rover, bench):
    made = rover(enb="gnd")
    bench.run_for(1.5)
    made.board.run()
    turns = made.body.wheel("wheel_lf").angle_rad / math.tau
    falls = sum(level is False for level in made.pins["PB3"].driven)
    assert falls == pytest.approx(turns * 20, abs=1)
    assert made.pins["PB4"].driven == [True]
    assert falls == made.parts.by_name["tacho_lf"].pulses


@pytest.mark.needs_physics
def test_in_a_room_it_drives_and_at_a_wall_it_stands(rover, bench):
    made = rover("rover-room", ena="brain.PA0", enb="brain.PA0")
    pulse(made, "PA0", 0.45, 0.0, 7.0)
    bench.run_for(1.0)
    assert made.world.pose().position_m[0] > 0.1
    bench.run_for(5.5)
    assert made.body.touches("body")
    assert made.world.pose().position_m[0] == pytest.approx(1.275, abs=2e-3)
