"""Bench files with parts: what they mean, and that each mistake is one line with its place and what to do."""

from __future__ import annotations

import math

import pytest

from hilbench.benchfile.bench_file import Net, PinEnd, TerminalEnd
from hilbench.errors import HilbenchError
from targets.parts.distance_switch import DistanceSwitchSettings

BRAIN = 'version = 1\n[targets.brain]\nboard = "bluepill"\nfirmware = "a.elf"\n'  # lines 1 to 4
ROBOT = '[targets.robot]\nmodel = "pioneer-2dx"\n'
SWITCH = '[parts.s]\nkind = "distance-switch"\npins = { out = "brain.PA4" }\nsignals = { range = "world.ray_1" }\n'
MOTOR = (
    '[parts.m]\nkind = "motor-code"\npins = { comm1 = "brain.PB7", comm2 = "brain.PB6", comm3 = "brain.PB5" }\n'
    'signals = { speed = "world.wheel_left" }\n'
)
ADAPTER = '[parts.a]\nkind = "p2os-adapter"\npins = { dd1 = "brain.PA4" }\n'
LINE = '[[links]]\nends = ["a.uart2", "robot.host"]\n'


def end(part, terminal):
    return TerminalEnd(part=part, terminal=terminal)


def test_a_part_is_its_kind_its_settings_and_its_signals(read):
    bench = read(BRAIN + SWITCH + "settings = { threshold_m = 0.3 }\n")
    part = bench.parts["s"]
    assert part.kind == "distance-switch"
    assert part.settings == DistanceSwitchSettings(threshold_m=0.3)
    assert part.signals == {"range": "ray_1"}
    assert bench.has_world
    assert bench.nets == (Net(pins=(PinEnd(board="brain", pin="PA4"),), terminals=(end("s", "out"),)),)


def test_wires_that_touch_a_terminal_are_one_net(read):
    text = BRAIN + MOTOR.replace('"brain.PB7"', '"3v3"') + '[[wires]]\nends = ["m.comm3", "brain.B9"]\n'
    nets = {str(terminal): net for net in read(text).nets for terminal in net.terminals}
    assert nets["m.comm1"].supplies == {"3v3"}
    assert nets["m.comm1"].pins == ()
    assert {pin.pin for pin in nets["m.comm3"].pins} == {"PB5", "PB9"}


def test_a_part_has_a_line_to_the_robot(read):
    bench = read(BRAIN + ROBOT + ADAPTER + LINE)
    assert [link.ends for link in bench.links] == [("a.uart2", "robot.host")]
    assert bench.links[0].baud == 9600


def test_without_a_robot_an_adapter_may_stand_for_itself(read):
    assert not read(BRAIN + ADAPTER).has_world


TWO_WHEELS = MOTOR + MOTOR.replace("[parts.m]", "[parts.n]")

WRONG = {
    "two parts drive one net": (
        BRAIN + SWITCH + SWITCH.replace("[parts.s]", "[parts.t]"),
        11,
        "s.out and t.out drive one wire; give each a pin of its own",
    ),
    "one part drives one net twice": (
        BRAIN + ADAPTER.replace("}", ', dd2 = "brain.PA4" }'),
        7,
        "a.dd1 and a.dd2 drive one wire; give each a pin of its own",
    ),
    "a part drives what a supply holds": (
        BRAIN + SWITCH.replace("brain.PA4", "3v3"),
        7,
        "s.out drives a wire that 3v3 holds; join it to a pin instead",
    ),
    "a pin that the board has not": (
        BRAIN + SWITCH.replace("PA4", "PD9"),
        7,
        "'brain' has no pin 'PD9'; did you mean 'PD1'?",
    ),
    "a pin in small letters": (BRAIN + SWITCH.replace("PA4", "pa4"), 7, "did you mean 'PA4'?"),
    "a board that there is not": (BRAIN + SWITCH.replace("brain.PA", "brian.PA"), 7, "did you mean 'brain.PIN'?"),
    "a USART as a pin": (
        BRAIN + SWITCH.replace("PA4", "usart1"),
        7,
        "'brain.usart1' is a serial line, not a pin; join lines under [[links]]",
    ),
    "a serial end as a wire": (
        BRAIN + ADAPTER.replace("dd1", "uart2"),
        7,
        "'a.uart2' is a serial line, not a wire; join lines under [[links]]",
    ),
    "a quantity under pins": (
        BRAIN + '[parts.s]\nkind = "distance-switch"\npins = { out = "brain.PA4", range = "world.ray_1" }\n',
        7,
        "'range' is a quantity, not a wire; put it under signals: range = ...",
    ),
    "a quantity in a wire": (
        BRAIN + SWITCH + '[[wires]]\nends = ["s.range", "brain.PA5"]\n',
        10,
        "'s.range' is a quantity, not a wire; put it under signals: range = ...",
    ),
    "a terminal under signals": (
        BRAIN + SWITCH.replace("signals = {", 'signals = { out = "brain.PA5",'),
        8,
        "'out' is a terminal; put it under pins: out = ...",
    ),
    "an unknown signal": (
        BRAIN + SWITCH.replace("ray_1", "rey_1"),
        8,
        "no signal 'world.rey_1'; did you mean 'world.ray_1'?",
    ),
    "a pin as a signal": (
        BRAIN + SWITCH.replace("world.ray_1", "brain.PA5"),
        8,
        "no signal 'brain.PA5'; it can be world.ray_1, world.sonar_1, world.ray_2, world.sonar_2, ...",
    ),
    "an unknown kind": (
        BRAIN + SWITCH.replace("switch", "swich"),
        6,
        "no kind of part 'distance-swich'; did you mean 'distance-switch'?",
    ),
    "an unknown setting": (
        BRAIN + SWITCH + "settings = { treshold_m = 0.5 }\n",
        9,
        "unknown key 'treshold_m' in [parts.s.settings]; did you mean 'threshold_m'?",
    ),
    "a setting out of its bounds": (
        BRAIN + SWITCH + "settings = { threshold_m = -1.0 }\n",
        9,
        "threshold_m must be at least 0.0, not -1.0",
    ),
    "a setting of another type": (
        BRAIN + SWITCH + 'settings = { threshold_m = "near" }\n',
        9,
        "'parts.s.settings.threshold_m': must be a number, not a text",
    ),
    "a choice that there is not": (
        BRAIN + SWITCH + 'settings = { profile = "simulator" }\n',
        9,
        "'simulator' is not a value it takes; did you mean 'simulation'?",
    ),
    "an unknown terminal": (
        BRAIN + SWITCH.replace("out", "ot"),
        7,
        "'s' has no terminal 'ot'; did you mean 'out'?",
    ),
    "an unknown quantity": (
        BRAIN + SWITCH.replace("range", "rang"),
        8,
        "a distance-switch has no quantity 'rang'; did you mean 'range'?",
    ),
    "a wheel that two parts drive": (
        BRAIN + TWO_WHEELS.replace("PB7", "PA1", 1).replace("PB6", "PA2", 1).replace("PB5", "PA3", 1),
        12,
        "world.wheel_left is driven by 'm' already; take the other wheel, or leave one of the two parts out",
    ),
    "a wheel beside the controller of a robot": (
        BRAIN + ROBOT + MOTOR,
        10,
        "world.wheel_left is driven by the controller of 'robot'; leave out [targets.robot], or this",
    ),
    "a unit that does not fit": (
        BRAIN + SWITCH.replace("ray_1", "wheel_left_angle"),
        8,
        "'world.wheel_left_angle' is in rad, and this in m; it can be world.ray_1, world.sonar_1",
    ),
    "a signal the other way": (
        BRAIN + MOTOR.replace("wheel_left", "wheel_left_angle"),
        8,
        "'world.wheel_left_angle' is what the world gives; it can be world.wheel_left, world.wheel_right",
    ),
    "rays in a physics without": (
        BRAIN + '[world]\nphysics = "plane"\n' + SWITCH,
        10,
        'no rays, and nothing would ever be seen; under [world] leave out physics = "plane"',
    ),
    "a terminal that is needed": (
        BRAIN + SWITCH.replace('pins = { out = "brain.PA4" }\n', ""),
        5,
        "'s': its terminal 'out' (high: obstacle) is open; add pins = { out = \"BOARD.PIN\" }",
    ),
    "a quantity that is needed": (
        BRAIN + SWITCH.replace('signals = { range = "world.ray_1" }\n', ""),
        5,
        "its quantity 'range' (distance, inf without an echo) is nothing; add signals = { range = \"world.ray_1\" }",
    ),
    "a wire between parts alone": (
        BRAIN + MOTOR.replace('"brain.PB7"', '"s.out"') + SWITCH.replace("brain.PA4", "m.comm1"),
        7,
        "m.comm1 and s.out: no pin of a board is on this wire; join one of them to a pin",
    ),
    "a part named like a target": (
        BRAIN + SWITCH.replace("[parts.s]", "[parts.brain]"),
        5,
        "'brain' is the name of a target already; give the part another name",
    ),
    "a part named like the world": (BRAIN + SWITCH.replace("[parts.s]", "[parts.world]"), 5, "the world already"),
    "a part named like a supply": (BRAIN + SWITCH.replace("[parts.s]", "[parts.gnd]"), 5, "a supply already"),
    "a dot in a name": (BRAIN + SWITCH.replace("parts.s", 'parts."s.t"'), 5, "has no dot; write [parts.s_t]"),
    "a line to nobody": (
        BRAIN + ADAPTER + '[[links]]\nends = ["a.uart2", "peer"]\n',
        9,
        'a line of a part leads to a board or to a robot; write ends = [..., "brain.usart1"]',
    ),
    "no line to the robot": (
        BRAIN + ROBOT + ADAPTER,
        7,
        "'a': its serial end 'uart2' leads nowhere; add [[links]] with ends = [\"a.uart2\", \"robot.host\"]",
    ),
    "two lines to one robot": (
        BRAIN + ROBOT + ADAPTER + LINE + '[[links]]\nends = ["brain.usart1", "robot.host"]\n',
        13,
        "'robot.host' has a line already",
    ),
    "a line with an unknown end": (
        BRAIN + ROBOT + ADAPTER + LINE.replace("uart2", "uart1"),
        11,
        "'a.uart1' is not the end of a link; did you mean 'a.uart2'?",
    ),
    "a world in which nothing stands": (
        BRAIN + ADAPTER + '[world]\nscene = "empty"\n',
        8,
        "no target of this bench has a world",
    ),
    "a variant that is not there": (
        BRAIN + '[variants]\nrobot = "other.toml"\n',
        6,
        "no file '",
    ),
    "a suite that is not there": (
        'suites = ["bluepill-pin"]\n' + BRAIN,
        1,
        "no suite 'bluepill-pin'; did you mean 'bluepill-pins'?",
    ),
}


@pytest.mark.parametrize(("text", "line", "message"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_one_line_with_its_place_and_the_fix(read, tmp_path, text, line, message):
    with pytest.raises(HilbenchError) as raised:
        read(text)
    said = str(raised.value)
    assert message in said
    assert said.startswith(f"{tmp_path / 'my.toml'}:{line}: ")
    assert "\n" not in said
    assert len(said) < 400


def test_no_setting_is_infinite(read):
    with pytest.raises(HilbenchError, match="threshold_m must be finite"):
        read(BRAIN + SWITCH + f"settings = {{ threshold_m = {math.inf} }}\n")
