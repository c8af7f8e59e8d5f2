#!/usr/bin/env python3
"""Talks to a Pioneer in raw bytes, with nothing but the standard library, and times its watchdog.

    hilbench serve pioneer --pty ./p2          in one shell
    python3 examples/clients/raw_bytes.py ./p2      in another

Every packet below is written out: FA FB, count, body, checksum (Pioneer 2 Operations Manual, client-server chapter).
"""

from __future__ import annotations

import itertools
import os
import select
import sys
import time
import tty

SYNC0 = bytes.fromhex("FA FB 03 00 00 00")
SYNC1 = bytes.fromhex("FA FB 03 01 00 01")
SYNC2 = bytes.fromhex("FA FB 03 02 00 02")
PULSE, OPEN, CLOSE = SYNC0, SYNC1, SYNC2  # the same bytes mean this once a session is open
ENABLE_1 = bytes.fromhex("FA FB 06 04 3B 01 00 05 3B")
VEL_200 = bytes.fromhex("FA FB 06 0B 3B C8 00 D3 3B")


class Line:
    """A serial port, the bytes that came from it, and when."""

    def __init__(self, path: str) -> None:
        self.descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.descriptor)
        self.pending = b""

    def write(self, data: bytes) -> float:
        os.write(self.descriptor, data)
        return time.monotonic()

    def packets(self, for_s: float) -> list[tuple[float, bytes]]:
        """Return the packets that end within the next seconds, each with its time."""
        found, end = [], time.monotonic() + for_s
        while (left := end - time.monotonic()) > 0:
            if select.select([self.descriptor], [], [], left)[0]:
                self.pending += os.read(self.descriptor, 4096)
                found += [(time.monotonic(), packet) for packet in self.split()]
        return found

    def split(self) -> list[bytes]:
        packets = []
        while (start := self.pending.find(b"\xfa\xfb")) >= 0 and len(self.pending) > start + 2:
            end = start + 3 + self.pending[start + 2]
            if len(self.pending) < end:
                break
            packets.append(self.pending[start:end])
            self.pending = self.pending[end:]
        return packets


def sips(packets: list[tuple[float, bytes]]) -> list[tuple[float, bytes]]:
    return [(at, packet) for at, packet in packets if packet[3] in (0x32, 0x33)]


def speeds(sip: bytes) -> tuple[int, int]:
    return int.from_bytes(sip[10:12], "little", signed=True), int.from_bytes(sip[12:14], "little", signed=True)


def fail(text: str) -> None:
    sys.exit(f"raw_bytes: {text}")


def shake_hands(line: Line) -> None:
    for name, sync in (("SYNC0", SYNC0), ("SYNC1", SYNC1), ("SYNC2", SYNC2)):
        sent = line.write(sync)
        answer = line.packets(0.2)
        if not answer:
            fail(f"{name} has no answer")
        at, packet = answer[0]
        print(f"{name}: after {1000 * (at - sent):.1f} ms  {packet.hex(' ').upper()}")
    print("identification:", packet[4:-2].split(b"\0")[:3])


def watch_rate(line: Line) -> float:
    line.write(OPEN)
    seen = sips(line.packets(2.05))
    if len(seen) < 15:
        fail(f"only {len(seen)} SIPs in two seconds")
    steps = [1000 * (b - a) for (a, _), (b, _) in itertools.pairwise(seen)]
    mean = sum(steps) / len(steps)
    print(f"SIPs: {len(seen)}, one each {mean:.1f} ms (from {min(steps):.1f} to {max(steps):.1f})")
    return mean


def drive_then_fall_silent(line: Line, cycle_ms: float) -> None:
    line.write(ENABLE_1)
    line.write(VEL_200)
    for _ in range(4):
        line.packets(0.5)
        last_write = line.write(PULSE)
    seen = sips(line.packets(4.0))
    cruising = [at for at, sip in seen if min(speeds(sip)) >= 195]
    stopped = [at for at, sip in seen if sip[3] == 0x32 and speeds(sip) == (0, 0)]
    if not cruising or not stopped:
        fail("the robot never drove, or its watchdog never stopped it")
    slowing_s, stopped_s = cruising[-1] - last_write, stopped[0] - last_write
    print(f"last SIP at full speed {slowing_s:.3f} s after the last byte sent (true within +{cycle_ms:.0f} ms)")
    print(f"first SIP that says stopped {stopped_s:.3f} s after it (true within -{cycle_ms:.0f} ms)")
    if not 1.8 < slowing_s < 2.2 or not slowing_s < stopped_s < 3.2:
        fail("that is not a watchdog of 2 s and a deceleration of 300 mm/s2")


def close(line: Line) -> None:
    line.write(CLOSE)
    line.packets(0.2)
    left = line.packets(1.0)
    print(f"after CLOSE: {len(left)} packets in a second")
    if left:
        fail("the robot talks on")


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: raw_bytes.py PORT")
    line = Line(sys.argv[1])
    shake_hands(line)
    drive_then_fall_silent(line, watch_rate(line))
    close(line)


if __name__ == "__main__":
    main()
