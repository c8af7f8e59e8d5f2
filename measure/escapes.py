"""``python -m measure.escapes NAME``: a wrong peer behind ptys, in real time, and what `hilbench check` says of it.

Each has one fault that a check once passed (docs/escapes.md). ``--hilbench`` names the command of another version;
words that are not known here go to it. The exit code is that of the check.
"""

from __future__ import annotations

import argparse
import os
import select
import struct
import subprocess
import sys
from collections.abc import Callable
from typing import Any

from measure.right_peers import at_port
from measure.right_peers.pioneer_robot import PioneerRobot
from measure.right_peers.rover_board import RoverBoard, crc16, framed
from measure.right_peers.vehicle_board import MANUAL, VehicleBoard


class NeverStops(RoverBoard):
    """Its motors run on when the link is lost."""

    def poll(self, now_s: float) -> bytes:
        """See `RoverBoard`."""
        self._heard_s = now_s
        return super().poll(now_s)


class HalfACrc(RoverBoard):
    """It compares one byte of a CRC."""

    _takes: Callable[[bytes, bytes, bytes], bool] = staticmethod(lambda _payload, crc, right: crc[1] == right[1])

    def _look(self) -> tuple[int | None, int]:
        data = self._buffer
        if len(data) > 5 and len(data) >= (end := data[4] + 7):
            payload, crc = bytes(data[5 : end - 2]), bytes(data[end - 2 : end])
            if self._takes(payload, crc, right := crc16(payload).to_bytes(2, "big")):
                data[end - 2 : end] = right
        return super()._look()


class AnswersTooSoon(HalfACrc):
    """It answers a request whatever its CRC is."""

    _takes = staticmethod(lambda payload, _crc, _right: payload[0] == 0)


class SwallowsFlowControl(RoverBoard):
    """XON and XOFF never reach it."""

    def feed(self, data: bytes, now_s: float) -> bytes:
        """See `RoverBoard`."""
        return super().feed(data.translate(None, b"\x11\x13"), now_s)


class RefusesAByteTooMany(RoverBoard):
    """It refuses an 0x04 with a byte behind its parameters."""

    def _run(self, opcode: int, given: bytes) -> int:
        return 6 if opcode == 4 and len(given) > 9 else super()._run(opcode, given)


class ReservedByte(RoverBoard):
    """A reserved byte of 0x83 has a value."""

    def _report_83(self) -> bytes:
        return b"\x83\x07" + super()._report_83()[2:]


class SwappedCrc(RoverBoard):
    """It has the low byte of its CRCs first."""

    def _say(self, payload: bytes) -> None:
        frame = framed(payload)
        self._out.append(frame[:-3] + frame[-2:-4:-1] + frame[-1:])


class NoBattery(PioneerRobot):
    """Its battery is always at 0 V."""

    def _sip(self) -> bytes:
        body = super()._sip()
        return body[:11] + b"\0" + body[12:]


class NoEmergencyFromManual(VehicleBoard):
    """In MANUAL it does not notice that statuses stop."""

    def _take_status(self) -> bool:
        return super()._take_status() or self._mode == MANUAL


class OneEmergency(VehicleBoard):
    """It says EMERGENCY once and not again."""

    _said = False

    def _drive(self, figures: tuple[float, ...], mode: int) -> None:
        if mode or not self._said:
            super()._drive(figures, mode)
        self._said = not mode


SUITES = {
    "pkt": ("rover-model", "pkt-board"),
    "p2os": ("pioneer-plane", "p2os-server"),
    "carla": ("vehicle-model", "vehicle-board"),
}
BOARDS: dict[str, tuple[str, Callable[[float], Any]]] = {
    "rover-never-stops": ("pkt", NeverStops),
    "rover-half-a-crc": ("pkt", HalfACrc),
    "rover-answers-too-soon": ("pkt", AnswersTooSoon),
    "rover-swallows-xon-xoff": ("pkt", SwallowsFlowControl),
    "rover-refuses-a-byte-too-many": ("pkt", RefusesAByteTooMany),
    "rover-reserved-byte": ("pkt", ReservedByte),
    "rover-swapped-crc": ("pkt", SwappedCrc),
    "robot-no-battery": ("p2os", NoBattery),
    "vehicle-no-emergency-from-manual": ("carla", NoEmergencyFromManual),
    "vehicle-one-emergency": ("carla", OneEmergency),
}
HOSTS = {
    "host-big-endian": struct.pack(">ff", 0.5, -0.25),
    "host-percent": struct.pack("<ff", 50.0, -25.0),
    "host-beyond-1": struct.pack("<ff", 1.5, -0.25),
    "host-doubles": struct.pack("<dd", 0.5, -0.25),
    "host-cut": b"\0\x3f",
}


def served(name: str) -> Any:
    """Return what makes a wrong board, as `measure.right_peers.at_port` has them."""
    protocol, make = BOARDS[name]
    return make if protocol == "carla" else lambda now_s: at_port.OneLine(make(now_s))


def _be_host(throttles: bytes, path: str) -> None:
    """Ask and command twice a second until somebody interrupts, then stop the motors."""
    line = os.open(path, os.O_RDWR | os.O_NOCTTY)
    try:
        while True:
            os.write(line, framed(b"\0\0") + framed(b"\x03" + throttles + b"\x03"))
            select.select([], [], [], 0.4)
    except KeyboardInterrupt:
        os.write(line, framed(b"\x03" + bytes(8) + b"\x03"))


def main() -> int:
    """Run one check; return its exit code."""
    parser = argparse.ArgumentParser(prog="python -m measure.escapes", description=__doc__)
    parser.add_argument("name", choices=[*BOARDS, *HOSTS])
    parser.add_argument("--hilbench", default="hilbench", help="the command that judges (default: hilbench)")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--host", help=argparse.SUPPRESS)
    chosen, more = parser.parse_known_args()
    me = [sys.executable, "-m", "measure.escapes", chosen.name]
    if chosen.host:
        _be_host(HOSTS[chosen.name], chosen.host)
    elif chosen.name in HOSTS:
        words = ["rover-model", "--suite=pkt-host", f"--target=exec:{' '.join(me)} --host {{pty}}"]
        return subprocess.run([chosen.hilbench, "check", *words, *more], check=False).returncode
    elif chosen.serve:
        protocol, _ = BOARDS[chosen.name]
        at_port.PEERS[protocol] = served(chosen.name)
        at_port.main(protocol)
    else:
        bench, suite = SUITES[protocol := BOARDS[chosen.name][0]]
        with subprocess.Popen([*me, "--serve"], stdout=subprocess.PIPE, text=True) as peer:
            assert peer.stdout is not None
            ptys = zip(at_port.LINES[protocol], peer.stdout.readline().split(), strict=True)
            targets = [f"--target={line}=serial:{pty}".replace("==", "=") for line, pty in ptys]
            words = [bench, f"--suite={suite}", *targets]
            done = subprocess.run([chosen.hilbench, "check", *words, *more], check=False)
            peer.terminate()
        return done.returncode
    return 0


if __name__ == "__main__":
    sys.exit(main())
