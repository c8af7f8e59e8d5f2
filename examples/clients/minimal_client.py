"""A small P2OS client that stands alone: connects to a robot, drives a little, prints what the robot says.

    python minimal_client.py /dev/ttyUSB0          a serial port, or a pseudo-terminal of hilbench
    python minimal_client.py localhost:8101        a robot behind TCP
    Ctrl-C                                         stops the robot, closes the session, ends

It needs Linux and nothing but Python. It shows what a client has to mind: no packet is acknowledged, bytes come in
pieces of any size, a bad packet is silently dropped, the same bytes mean different things before and after OPEN, and a
robot that hears nothing for 2 s stops. Source of the protocol: Pioneer 2 Operations Manual, client-server chapter.
"""

from __future__ import annotations

import argparse
import os
import select
import signal
import socket
import struct
import sys
import termios
import time
import tty

HEADER = b"\xfa\xfb"
SYNC0, SYNC1, SYNC2 = 0, 1, 2
PULSE, OPEN, CLOSE, ENABLE, VEL, RVEL, CONFIG = 0, 1, 2, 4, 11, 21, 18
STOPPED, MOVING, CONFIG_REPLY, RESET = 0x32, 0x33, 0x20, (0xFF, 0xFE)
KNOWN = ("p2dx", "p2de", "p2df", "p2at", "p2pb", "p3dx", "p3at", "amigo")
MM_PER_UNIT = 0.84  # of a p2dx; other robots have other units

SYNC_TIMEOUT_S = 1.0
SILENT_TRIES = 6
TRIES = 20
OLD_SESSION_QUIET_S = 0.3
PULSE_EVERY_S = 0.5
SIP_TIMEOUT_S = 8.0


class RobotError(Exception):
    """The robot cannot be reached, or is gone."""


def checksum(body: bytes) -> int:
    """Big-endian words added modulo 65536; a last odd byte is XORed into the low byte."""
    total = sum(body[i] << 8 | body[i + 1] for i in range(0, len(body) - 1, 2)) & 0xFFFF
    return total ^ body[-1] if len(body) % 2 else total


def packet(number: int, argument: int | None = None) -> bytes:
    """A whole packet; an integer argument goes as its magnitude, the sign in the type byte."""
    body = bytes((number,))
    if argument is not None:
        body += struct.pack("<BH", 0x1B if argument < 0 else 0x3B, abs(argument))
    return HEADER + bytes((len(body) + 2,)) + body + struct.pack(">H", checksum(body))


class Line:
    """The serial port or the socket, and the packets that come out of it."""

    def __init__(self, where: str, baud: int) -> None:
        host, colon, port = where.rpartition(":")
        self._socket = socket.create_connection((host, int(port)), 5) if colon else None
        self.descriptor = self._socket.fileno() if self._socket else open_serial(where, baud)
        self._held = b""
        self.bodies: list[bytes] = []

    def send(self, number: int, argument: int | None = None) -> None:
        os.write(self.descriptor, packet(number, argument))

    def receive(self, timeout_s: float) -> bytes | None:
        """The body of the next sound packet, or None if none comes in time."""
        end_s = time.monotonic() + timeout_s
        while not self.bodies:
            left_s = end_s - time.monotonic()
            if left_s <= 0 or not select.select([self.descriptor], [], [], left_s)[0]:
                return None
            data = os.read(self.descriptor, 4096)
            if not data:
                raise RobotError("the line was closed")
            self._held += data
            self._take_packets()
        return self.bodies.pop(0)

    def forget(self) -> None:
        self.bodies.clear()

    def close(self) -> None:
        if self._socket:
            self._socket.close()
        else:
            termios.tcdrain(self.descriptor)
            os.close(self.descriptor)

    def _take_packets(self) -> None:
        while True:
            start = self._held.find(HEADER)
            if start < 0:
                self._held = self._held[-1:] if self._held.endswith(HEADER[:1]) else b""
                return
            self._held = self._held[start:]
            if len(self._held) < 3:
                return
            end = 3 + self._held[2]
            if not 3 <= self._held[2] <= 207:
                self._held = self._held[2:]
            elif len(self._held) < end:
                return
            elif checksum(self._held[3 : end - 2]) == int.from_bytes(self._held[end - 2 : end], "big"):
                self.bodies.append(self._held[3 : end - 2])
                self._held = self._held[end:]
            else:
                self._held = self._held[2:]  # a sound packet may begin inside the bad one


def open_serial(path: str, baud: int) -> int:
    """Open a serial port raw, 8N1."""
    descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(descriptor)
    attributes = termios.tcgetattr(descriptor)
    attributes[4] = attributes[5] = getattr(termios, f"B{baud}")
    termios.tcsetattr(descriptor, termios.TCSANOW, attributes)
    return descriptor


def connect(line: Line) -> None:
    """Walk through SYNC0, SYNC1, SYNC2 and open the session."""
    step, tries, answered = SYNC0, 0, False
    while True:
        tries += 1
        if tries > (TRIES if answered else SILENT_TRIES):
            raise RobotError("no session came about" if answered else "nobody answers")
        line.send(step)
        body = line.receive(SYNC_TIMEOUT_S)
        if body is None:
            continue
        answered = True
        if body[0] in (STOPPED, MOVING):
            close_old_session(line)
            step = SYNC0
        elif body[0] != step:
            time.sleep(0.2)
            line.forget()
            step = SYNC0
        elif step != SYNC2:
            step += 1
        else:
            break
    identify(line, body)
    time.sleep(0.1)
    line.send(OPEN)


def close_old_session(line: Line) -> None:
    """Somebody left a session open: close it, and wait until the robot is silent."""
    for _ in range(20):
        line.send(CLOSE, 1)  # with an argument it can never be taken for SYNC2
        line.forget()
        if line.receive(OLD_SESSION_QUIET_S) is None:
            return
    raise RobotError("an old session would not close")


def identify(line: Line, body: bytes) -> None:
    """Read the three strings of the answer to SYNC2."""
    strings = body[1:].split(b"\0")
    if len(strings) < 4:
        raise RobotError("the robot did not say what it is")
    name, robot_class, subclass = (string.decode("latin-1") for string in strings[:3])
    print(f"connected to '{name}', a {robot_class} {subclass}", flush=True)
    if subclass.lower() not in KNOWN:
        line.send(CLOSE, 1)
        raise RobotError(f"a robot of the kind '{subclass}' is unknown")


def print_sip(body: bytes) -> None:
    """Print some of a SIP; one that is shorter than it says is dropped."""
    if len(body) < 20 or len(body) < 25 + 3 * body[19]:
        return
    x, y, th, left, right, battery = struct.unpack_from("<HHhhhB", body, 1)
    x_mm, y_mm = (((value + 0x4000) % 0x8000 - 0x4000) * MM_PER_UNIT for value in (x, y))
    print(
        f"x {x_mm:8.1f} mm  y {y_mm:8.1f} mm  heading {th * 360 / 4096:7.2f} deg  "
        f"wheels {left:5} {right:5} mm/s  {battery / 10:.1f} V  {body[19]} sonar readings",
        flush=True,
    )


def drive(line: Line) -> None:
    """Drive in a wide circle, slowly, until the user or the robot ends it."""
    now_s = time.monotonic()
    sent_s = sip_s = now_s
    line.send(CONFIG, 1)
    for number, argument in ((ENABLE, 1), (VEL, 150), (RVEL, 10)):
        line.send(number, argument)
    while True:
        body = line.receive(max(0.0, sent_s + PULSE_EVERY_S - time.monotonic()))
        now_s = time.monotonic()
        if body is not None and body[0] in RESET:
            raise RobotError("the controller was reset")
        if body is not None and body[0] in (STOPPED, MOVING):
            sip_s = now_s
            print_sip(body)
        if now_s - sip_s > SIP_TIMEOUT_S:
            raise RobotError("the robot has fallen silent")
        if now_s - sent_s >= PULSE_EVERY_S:
            line.send(PULSE)
            sent_s = now_s


def leave(line: Line) -> None:
    """Stop the robot, close the session."""
    line.send(ENABLE, 0)
    time.sleep(0.1)
    line.send(CLOSE, 1)


def main() -> int:
    """Run until Ctrl-C; 1 if the robot could not be reached or was lost."""
    parser = argparse.ArgumentParser(description="a minimal P2OS client")
    parser.add_argument("where", help="path of a serial port, or HOST:PORT")
    parser.add_argument("--baud", type=int, default=9600)
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    line = Line(arguments.where, arguments.baud)
    connected = False
    try:
        connect(line)
        connected = True
        drive(line)
    except KeyboardInterrupt:
        if connected:
            leave(line)
        return 0
    except RobotError as error:
        print(error, file=sys.stderr)
        return 1
    finally:
        line.close()


if __name__ == "__main__":
    raise SystemExit(main())
