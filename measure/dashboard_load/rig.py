"""A bench with one line, full both ways: whole frames back to back, read at both ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import BenchFile
from hilbench.clock import NS_PER_MS, EventClass
from hilbench.driving.rig import Rig
from hilbench.driving.tap import Tap
from hilbench.exit_codes import ExitCode
from hilbench.links import Line, MemoryLink, Port
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.live import session
from hilbench.live.folders import Session
from hilbench.mcu.command_line import open_target
from hilbench.systems.rover.about import about_pkt
from protocols import pkt

BAUD = 921_600
PROFILE = "documented"
_FEED_NS = 5 * NS_PER_MS
_AHEAD_NS = 15 * NS_PER_MS
_FRAMES_AT_ONCE = 10


def serve(folder: Path) -> ExitCode:
    """Be the process of a live bench with that rig, until it is told to end."""
    session.open_rig = open_saturated
    return session.run_live(open_target("rover-model"), session.LiveOptions(session=Session(folder)))


def open_saturated(bench: Bench, _bench_file: BenchFile, *, seed: int) -> Rig:
    """Build it, in the place of `hilbench.live.rigs.open_rig`."""
    link = MemoryLink(bench.scheduler, Line(baud=BAUD), name="host", group_ns=REAL_TIME_GROUP_NS)
    tap = Tap(bench, link.a, "station", seed=seed)
    server = pkt.PROFILES[PROFILE].server
    commands = [pkt.encode_frame(pkt.encode_command(pkt.RequestTelemetry(), server.schema), server.frames)]
    reports = [pkt.encode_frame(bytes.fromhex("06800000000000"), server.frames)]
    for name, port, frames in (("station", tap, commands), ("rover", link.b, reports)):
        reader = pkt.FrameReader(server.frames)
        port.on_receive = partial(_read, reader)
        _feed(bench, name, port, frames)
    return Rig(machines={}, taps={"host": tap}, about=about_pkt("station", {}, PROFILE), demo=False)


def _read(reader: pkt.FrameReader, data: bytes, at_ns: int) -> None:
    for _ in reader.receive(data, at_ns):
        pass


def _feed(bench: Bench, name: str, port: Port, frames: Sequence[bytes]) -> None:
    """Never let the port run dry."""
    data = b"".join(frames) * _FRAMES_AT_ONCE
    ahead = BAUD // 10 * _AHEAD_NS // 1_000_000_000
    again: Callable[[], None] = partial(_feed, bench, name, port, frames)
    written = b""
    while port.pending + len(written) < ahead:
        written += data
    if written:
        bench.record("tx", name, data=written)
        port.write(written)
    bench.scheduler.after(_FEED_NS, again, order=EventClass.CONTROL, source=f"~{name}")
