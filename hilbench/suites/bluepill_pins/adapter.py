"""How the adapter reads its wires, and what becomes of a robot when they fall silent."""

from __future__ import annotations

from itertools import pairwise

import pytest

from hilbench.check import Inconclusive, at_least, at_most, near
from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.suites._bluepill import (
    CONNECT,
    LEFT_MOTOR,
    MOTORS,
    RIGHT_MOTOR,
    bits,
    connect,
    drive_codes,
    last,
    levels,
    signed,
)
from hilbench.suites._board_watch import Watch
from hilbench.suites.bluepill_pins._ways import SPEED, STOP_S, mean_mm_s, on_adapter, pulse, required
from targets.parts.p2os_adapter import CodesRead, ConnectionPin, RobotConnected, RobotLeft, RobotLost, SafeStopped

# --- G15, G16: how the adapter reads its wires


def echo(bench: BoardBench) -> bool:
    """Return whether the adapter drives its echo high."""
    return bench.emulated.surroundings.parts.driven("adapter", "echo") is True


@on_adapter("G15", program="quiet", lasts_s=2.05)
def test_short_pulses_do_not_connect(bench: BoardCase) -> None:
    """Seven of them, at all places of the window of 10 ms in which the wire is read."""
    watch = Watch(bench)
    bench.board.pin(CONNECT).drive(False)
    bench.board.run(1.2)
    for _ in range(7):
        pulse(bench, CONNECT, 0.005)
        bench.board.run(0.0957)
    required(not watch.reported(ConnectionPin), "a pulse of 5 ms was acted on", watch.reported(ConnectionPin))
    pulse(bench, CONNECT, 0.050)
    seen = [one.event.connected for one in watch.reported(ConnectionPin)]
    required(seen == [True], "a pulse of 50 ms was not acted on", watch.reported(ConnectionPin))
    required(echo(bench), "the echo is not high")
    bench.board.run(0.1)
    seen = [one.event.connected for one in watch.reported(ConnectionPin)]
    required(seen == [True, False], "the end of the pulse was not acted on", watch.reported(ConnectionPin))
    required(not echo(bench), "the echo is not low again")


@on_adapter("G15", program="quiet", lasts_s=1.7)
def test_the_first_second_does_not_connect(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.board.run(0.2)
    pulse(bench, CONNECT, 0.050)
    bench.board.run(0.25)
    bench.board.pin(CONNECT).drive(True)
    bench.board.run(0.45)
    required(
        not watch.reported(ConnectionPin) and not echo(bench), "acted on before 1 s", watch.reported(ConnectionPin)
    )
    bench.board.run(0.75)
    required([one.event.connected for one in watch.reported(ConnectionPin)] == [True], "not acted on after 1 s")
    at_least(watch.reported(ConnectionPin)[0].at_ns / NS_PER_S, 1.0, unit="s", what="first acted on")
    at_most(watch.reported(ConnectionPin)[0].at_ns / NS_PER_S, 1.02, unit="s", what="first acted on")
    required(echo(bench), "the echo is not high")


LEAVE_S = 1.0
"""How soon the robot has been let go after p2dx_con went low; its CLOSE goes out with the next command. A choice."""


@on_adapter("G15", program="quiet", lasts_s=4.6)
def test_the_robot_is_let_go(bench: BoardCase) -> None:
    """The robot moves when p2dx_con goes low: it gets a CLOSE, stands, and is taken up again by the next pulse."""
    watch = Watch(bench)
    connect(bench, watch, RobotConnected)
    drive_codes(bench.board, 3, 3)
    bench.board.run(1.0)
    if watch.samples[-1].still:
        raise Inconclusive("the robot does not move at codes 3, so that it cannot be seen to stand afterwards")
    low_ns = bench.now_ns
    bench.board.pin(CONNECT).drive(False)
    bench.board.run(2.0)
    left = last(watch.reported(RobotLeft, since_ns=low_ns), "the end of the session")
    at_most((left.at_ns - low_ns) / NS_PER_S, LEAVE_S, unit="s", what="time from p2dx_con going low to the end")
    closes = [at_ns for at_ns, data in watch.sent if at_ns >= low_ns and data == CLOSE]
    required(len(closes) == 1, f"{len(closes)} CLOSE went to the robot, not one")
    after = [data for at_ns, data in watch.sent if at_ns > closes[0]]
    required(not after, "the robot is sent something after the CLOSE", [data.hex(" ") for data in after])
    required(watch.samples[-1].still, "the robot still moves")
    again_ns = bench.now_ns
    bench.board.pin(CONNECT).drive(True)
    again = bench.board.run_until(lambda: bool(watch.reported(RobotConnected, since_ns=again_ns)), 2.0)
    required(again, "no other session 2 s after p2dx_con went high again")


SPACING_US = 100
"""Far enough apart that the reads can be told from each other: at 0, 100, 200, 300 and 400 us before the pass."""

PASSES = 6


@on_adapter("G16", program="quiet", lasts_s=0.029, pass_ms=1.0, motor_reads=5, motor_read_spacing_us=float(SPACING_US))
@pytest.mark.parametrize("pin", MOTORS)
@pytest.mark.parametrize(("reads", "seen"), [(2, False), (3, True)])
def test_majority_of_five(bench: BoardCase, pin: str, reads: int, seen: bool) -> None:
    """The adapter takes a pass each millisecond; before each of six the wire is high for the last reads of five."""
    watch = Watch(bench)
    bench.board.run(0.02)
    machine, wire = bench.emulated.machines[bench.board.name], bench.board.pin(pin)
    first_ns = bench.now_ns - bench.now_ns % NS_PER_MS + 2 * NS_PER_MS
    for number in range(PASSES):
        pass_ns = first_ns + number * NS_PER_MS
        machine.at_ns(pass_ns - int((reads - 0.5) * SPACING_US * 1000), lambda: wire.drive(True))
        machine.at_ns(pass_ns + 10_000, lambda: wire.drive(False))
    bench.board.run((first_ns + PASSES * NS_PER_MS - bench.now_ns) / NS_PER_S - 0.0005)
    codes = [(one.event.left, one.event.right) for one in watch.reported(CodesRead)]
    wanted = code_of_wire(pin)
    if seen:
        required(codes == [wanted], f"{pin} high in {reads} of 5 reads: codes {codes}, not {wanted}")
    else:
        required(not codes, f"{pin} high in {reads} of 5 reads: codes {codes}")
        wire.drive(True)
        bench.board.run(0.003)
        if not watch.reported(CodesRead):
            raise Inconclusive(f"{pin} counts as low where it is always high, too")


def code_of_wire(pin: str) -> tuple[int, int]:
    """Return the codes, left and right, that one motor wire alone stands for."""
    if pin in LEFT_MOTOR:
        return signed(1 << LEFT_MOTOR.index(pin)), 0
    return 0, signed(1 << RIGHT_MOTOR.index(pin))


# --- G17, G18: what becomes of a robot


@on_adapter("G17", program="halt", lasts_s=12.0)
def test_a_stopped_program_drives_on(bench: BoardCase) -> None:
    """The program stops after 5 s, with codes 3 on its wires; the robot's own watchdog, of 2 s, is kept quiet."""
    watch = Watch(bench)
    bench.board.run(12.0)
    required(levels(bench.board, MOTORS) == (*bits(3), *bits(3)), "the wires do not carry codes 3 any more")
    near(mean_mm_s(watch.span(9.0, 12.0)), 187, SPEED * 187, unit="mm/s", what="speed 4 to 7 s after the program ended")


SAFE_STOP_S = 3.0


@on_adapter("G17", program="halt", lasts_s=7.0, safe_stop_s=SAFE_STOP_S)
def test_a_stopped_program_is_noticed(bench: BoardCase) -> None:
    """The last that changed on the wires is p2dx_con, acted on after 1 s of uptime."""
    watch = Watch(bench)
    bench.board.run(7.0)
    changed_ns = last(watch.reported(ConnectionPin), "the connection").at_ns
    stopped = watch.reported(SafeStopped)
    required(len(stopped) == 1, f"stopped {len(stopped)} times, not once")
    within_s = (stopped[0].at_ns - changed_ns) / NS_PER_S
    near(within_s, SAFE_STOP_S, 0.01, unit="s", what="time from the last change of a wire to the stop")
    fastest = max(abs(one.speed_mm_s) for one in watch.samples)
    near(fastest, 187, SPEED * 187, unit="mm/s", what="speed before")
    moving = last([one for one in watch.samples if not one.still], "any motion")
    at_most(moving.after_s(stopped[0].at_ns), STOP_S, unit="s", what="time from the stop to rest")


PULSE = bytes.fromhex("fafb03000000")

CLOSE = bytes.fromhex("fafb03020002")

ENABLE = bytes.fromhex("fafb06043b0100053b")

WATCH_S = 10.0


@on_adapter("G18", program="quiet", lasts_s=11.3)
def test_the_robot_is_kept_alive(bench: BoardCase) -> None:
    watch = Watch(bench)
    connected_ns = connect(bench, watch, RobotConnected)
    bench.board.run(WATCH_S)
    for frame, name, every_s, off_s in ((PULSE, "PULSE", 0.5, 0.01), (ENABLE, "ENABLE", 0.1, 0.01)):
        times_ns = [at_ns for at_ns, data in watch.sent if at_ns >= connected_ns and data == frame]
        count = WATCH_S / every_s
        required(abs(len(times_ns) - count) <= 0.03 * count + 1, f"{len(times_ns)} {name} in {WATCH_S:g} s")
        for one, other in pairwise(times_ns):
            near((other - one) / NS_PER_S, every_s, off_s, unit="s", what=f"interval of {name}")
    required(not watch.reported(RobotLost), "the session was lost")
    required(all(one.still for one in watch.since(connected_ns)), "the robot moves")
