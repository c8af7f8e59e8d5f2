"""``python -m measure.xrce_agent``: how the agent takes reconnects, and what it passes on: docs/xrce/measured.md.

Reconnects are in bench time, at a line of 115200 bit/s, and so are the rates at serial lines; the rate over TCP is that
of the served program in real time. Each part is kept in docs/xrce/measured.json as soon as it is measured, and a run
that is begun anew goes on behind it; ``--again`` measures everything.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import random
import re
import selectors
import signal
import socket
import statistics
import subprocess
import sys
import time
import tracemalloc
from array import array
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor, LinesActor
from hilbench.clock import NS_PER_S, Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.xrce_agent.agent import agent_of
from hilbench.systems.xrce_agent.board import OBJECTS, READER, WRITER
from hilbench.systems.xrce_agent.client import ModelClient
from hilbench.systems.xrce_agent.settings import AgentSettings, ClientSettings
from protocols import xrce

DOCS = Path(__file__).parents[1] / "docs" / "xrce"
BAUD = 115_200
LINES = ("line1", "line2")
KEYS = (b"\x48\x42\x00\x03", b"\x48\x42\x00\x04")
AWAY_S = 0.1
"""How long an agent that was killed is away, and a line that was unplugged (choice)."""
PATIENCE_S = 60.0
MS = 1_000_000
LAST = [*OBJECTS][-1]
"""The object that a board creates last."""
TCP_BAUD = 4_000_000
"""The fastest that `hilbench serve --baud` takes."""


# --- reconnects


class Agents:
    """An agent that can be killed, as a device at several lines."""

    def __init__(self) -> None:
        self.service: xrce.AgentService | None = None
        self.start()

    def start(self) -> None:
        self.service = agent_of(AgentSettings(), LINES)

    def receive(self, line: str, data: bytes, now_ns: int) -> Iterable[tuple[str, bytes]]:
        return self.service.receive(line, data, now_ns) if self.service else ()

    def advance(self, now_ns: int) -> Iterable[tuple[str, bytes]]:
        return self.service.advance(now_ns) if self.service else ()

    def next_deadline_ns(self) -> int | None:
        return self.service.next_deadline_ns() if self.service else None

    def line_down(self, line: str, now_ns: int) -> Iterable[tuple[str, bytes]]:
        return self.service.line_down(line, now_ns) if self.service else ()

    def take_events(self) -> Iterable[object]:
        return self.service.take_events() if self.service else ()


class Board:
    """A board that can be switched off, on, and reset, as a device; it does not see that its cable was pulled."""

    def __init__(self) -> None:
        self.client: ModelClient | None = None

    def reset(self, key: bytes) -> None:
        self.client = ModelClient(ClientSettings(), key=key)

    def receive(self, data: bytes, now_ns: int) -> bytes:
        return self.client.receive(data, now_ns) if self.client else b""

    def advance(self, now_ns: int) -> bytes:
        return self.client.advance(now_ns) if self.client else b""

    def next_deadline_ns(self) -> int | None:
        return self.client.next_deadline_ns() if self.client else None

    def line_down(self, now_ns: int) -> bytes:
        del now_ns
        return b""

    def take_events(self) -> Iterable[object]:
        return self.client.take_events() if self.client else ()


class Rig:
    """An agent with two lines, and a board at each, the second one switched off."""

    def __init__(self, seed: int) -> None:
        self.bench = Bench(Scheduler(), Journal(keep=1))
        self.links = {
            name: MemoryLink(self.bench.scheduler, Line(baud=BAUD), name=name, group_ns=MS // 2) for name in LINES
        }
        self.agents = Agents()
        self.boards = {name: Board() for name in LINES}
        self.chance = random.Random(seed)
        self.there, self.key = 0, 0
        self.made: tuple[int, str] | None = None
        ends = {name: link.b for name, link in self.links.items()}
        self.actor = LinesActor(self.bench, self.agents, ends, name="agent", on_event=self._event)
        self.actors = {
            name: DeviceActor(self.bench, board, self.links[name].a, name=f"board-{name}")
            for name, board in self.boards.items()
        }

    @property
    def line(self) -> str:
        return LINES[self.there]

    def start(self) -> None:
        """The board at the line of now is switched on."""
        self.boards[self.line].reset(KEYS[self.key])
        self.actors[self.line].settle()

    def back(self) -> float:
        """Wait until the agent has all objects of the board at the line of now again; how long that took, in ms."""
        self.made, began_ns = None, self.bench.now_ns
        assert self.bench.run_until(lambda: self.made is not None and self.made[1] == self.line, PATIENCE_S)
        assert self.made is not None
        return (self.made[0] - began_ns) / MS

    def _event(self, event: object) -> None:
        if isinstance(event, xrce.ObjectCreated) and event.object_id == LAST:
            self.made = self.bench.now_ns, event.line


def _reset(rig: Rig) -> None:
    rig.start()


def _killed(rig: Rig) -> None:
    rig.agents.service = None
    rig.actor.settle()
    rig.bench.run_for(AWAY_S)
    rig.agents.start()
    rig.actor.settle()


def _unplugged(rig: Rig) -> None:
    rig.links[rig.line].hang_up()
    rig.bench.run_for(AWAY_S)
    rig.links[rig.line].restore()


def _deleted(rig: Rig) -> None:
    client = rig.boards[rig.line].client
    assert client is not None
    rig.actors[rig.line].transmit(client.leave(rig.bench.now_ns))


def _elsewhere(rig: Rig) -> None:
    rig.boards[rig.line].client = None
    rig.actors[rig.line].settle()
    rig.there = 1 - rig.there
    rig.start()


def _another(rig: Rig) -> None:
    rig.key = 1 - rig.key
    rig.start()


WAYS: Mapping[str, tuple[str, Callable[[Rig], None]]] = {
    "reset": ("the board is reset, and connects at once", _reset),
    "killed": (f"the agent is killed, and another one started {AWAY_S * 1000:.0f} ms later", _killed),
    "unplugged": (f"the line is unplugged for {AWAY_S * 1000:.0f} ms, which only the agent sees", _unplugged),
    "deleted": ("the client ends its session, and asks for another one", _deleted),
    "elsewhere": ("the same key comes at another line, while it has a session here", _elsewhere),
    "another": ("another key comes at the same line, while this one has a session", _another),
}


def reconnects(way: str, count: int) -> dict[str, Any]:
    """Reconnect so often in one way, at moments drawn by chance; times in ms, memory in bytes."""
    rig = Rig(seed=26)
    rig.start()
    rig.back()
    times, memory, held = array("d", bytes(8 * count)), array("q", bytes(16)), 0  # made before memory is watched
    tracemalloc.start()
    try:
        for number in range(count):
            rig.bench.run_for(rig.chance.uniform(1.05, 1.15))  # it writes as usual, at any moment
            began_ns = rig.bench.now_ns
            WAYS[way][1](rig)
            times[number] = (rig.bench.now_ns - began_ns) / MS + rig.back()
            assert rig.agents.service is not None
            held = max(held, rig.agents.service.held)
            if number in (count // 10, count - 1):
                gc.collect()
                memory[number > count // 10] = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert rig.agents.service is not None
    objects = sum(map(len, rig.agents.service.objects.values()))
    assert objects == len(OBJECTS), f"{objects} objects"
    return {
        "count": count,
        "median_ms": statistics.median(times),
        "most_ms": max(times),
        "memory_early": memory[0],
        "memory_late": memory[1],
        "held": held,
    }


def deaf(count: int) -> dict[str, Any]:
    """One client writes so many samples for another one, which asks for all of them and never reads."""
    options = xrce.ClientOptions(client_key=KEYS[0])
    writer = xrce.Session(xrce.Role.CLIENT, options)
    reader = xrce.Session(xrce.Role.CLIENT, xrce.ClientOptions(client_key=KEYS[1]))
    agent = agent_of(AgentSettings(), LINES)
    pair = {"line1": writer, "line2": reader}
    for line, session in pair.items():
        _passed(agent, line, session, session.connect(0))
        for object_id, made in OBJECTS.items():
            _say(agent, line, session, xrce.Create(request_id=1, object_id=object_id, object=made))
    wanted = xrce.ReadSpecification(stream_id=0x80, delivery=xrce.DeliveryControl(max_samples=xrce.UNLIMITED))
    _say(agent, "line2", reader, xrce.ReadData(request_id=2, object_id=READER, specification=wanted))
    memory, held = [], 0
    tracemalloc.start()
    try:
        for number in range(count):
            said = xrce.WriteData(request_id=3, object_id=WRITER, data=bytes(100))
            now_ns = number * 10 * MS
            for line, data in agent.receive("line1", writer.send(said, now_ns), now_ns):
                if line == "line1":
                    writer.receive(data, now_ns)
            agent.advance(now_ns)
            agent.take_events()
            held = max(held, agent.held)
            if number in (count // 10, count - 1):
                gc.collect()
                memory.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert agent.counters.routed == count
    return {"count": count, "held": held, "memory_early": memory[0], "memory_late": memory[1]}


def _say(agent: xrce.AgentService, line: str, session: xrce.Session, said: xrce.Submessage) -> None:
    _passed(agent, line, session, [xrce.Transmit(data=session.send(said, 0))])


def _passed(agent: xrce.AgentService, line: str, session: xrce.Session, events: Iterable[object]) -> None:
    """Hand what a client says to the agent, and back, until nobody says anything."""
    waiting = [event.data for event in events if isinstance(event, xrce.Transmit)]
    while waiting:
        for to, data in agent.receive(line, waiting.pop(0), 0):
            if to == line:
                heard = session.receive(data, 0)
                waiting += [event.data for event in heard if isinstance(event, xrce.Transmit)]


# --- rates


class End:
    """A client that writes as much as there is room for, or reads everything."""

    def __init__(self, key: bytes, *, reliable: bool, framing: xrce.Framing, write: Callable[[bytes], None]) -> None:
        frames = xrce.FramingOptions(framing=framing)
        self.session = xrce.Session(xrce.Role.CLIENT, xrce.ClientOptions(client_key=key, frames=frames))
        self.stream_id = xrce.BUILTIN_RELIABLE if reliable else xrce.BUILTIN_BEST_EFFORT
        self.reliable, self._write = reliable, write
        self.heard = self.sent = self.sent_bytes = self.answers = 0

    def take(self, events: Iterable[object]) -> None:
        for event in events:
            if isinstance(event, xrce.Transmit):
                self._write(event.data)
            elif isinstance(event, xrce.Received):
                self.heard += isinstance(event.submessage, xrce.TopicData)
                self.answers += isinstance(event.submessage, xrce.StatusReply)

    def receive(self, data: bytes, now_ns: int) -> None:
        self.take(self.session.receive(data, now_ns))

    def say(self, said: xrce.Submessage, now_ns: int, *, stream_id: int = xrce.BUILTIN_RELIABLE) -> int:
        data = self.session.send(said, now_ns, stream_id=stream_id)
        self._write(data)
        return len(data)

    def create(self, now_ns: int) -> None:
        for object_id, made in OBJECTS.items():
            self.say(xrce.Create(request_id=1, object_id=object_id, object=made), now_ns)

    def read(self, now_ns: int) -> None:
        delivery = xrce.DeliveryControl(max_samples=xrce.UNLIMITED)
        wanted = xrce.ReadSpecification(stream_id=self.stream_id, delivery=delivery)
        self.say(xrce.ReadData(request_id=2, object_id=READER, specification=wanted), now_ns)

    @property
    def has_room(self) -> bool:
        """One more sample goes at once, whatever the line does."""
        return not self.reliable or self.session.unacknowledged < xrce.StreamOptions().window

    def sample(self, size: int, now_ns: int) -> None:
        said = xrce.WriteData(request_id=3, object_id=WRITER, data=bytes(size))
        self.sent_bytes += self.say(said, now_ns, stream_id=self.stream_id)
        self.sent += 1


def frame_bytes(size: int, framing: xrce.Framing) -> int:
    """How long the frame of a sample is on the line, less what is escaped (these samples need nothing escaped)."""
    said = xrce.encode_submessage(xrce.WriteData(request_id=3, object_id=WRITER, data=bytes(size)))
    header = xrce.Header(session_id=0x81, stream_id=0x80)
    frames = xrce.FramingOptions(framing=framing)
    return len(xrce.encode_frame(xrce.encode_message(header, said), frames))


def serial_rate(baud: int, size: int, *, reliable: bool, seconds: float) -> dict[str, Any]:
    """The samples a second from one client to another, in bench time; the agent's CPU for each, in us."""
    bench = Bench(Scheduler(), Journal(keep=1))
    links = [MemoryLink(bench.scheduler, Line(baud=baud), name=name, group_ns=MS // 10) for name in LINES]
    agent, cpu_ns = agent_of(AgentSettings(), LINES), [0]

    def timed(work: Callable[[], xrce.Written]) -> None:
        began_ns = time.process_time_ns()
        written = work()
        agent.take_events()
        cpu_ns[0] += time.process_time_ns() - began_ns
        for line, data in written:
            links[LINES.index(line)].b.write(data)

    ends = []
    for number, link in enumerate(links):
        end = End(KEYS[number], reliable=reliable, framing=xrce.Framing.SERIAL, write=link.a.write)
        link.a.on_receive = end.receive
        line = LINES[number]
        link.b.on_receive = lambda data, at_ns, line=line: timed(lambda: agent.receive(line, data, at_ns))
        ends.append(end)

    def pass_time(seconds: float) -> None:
        end_ns = bench.now_ns + round(seconds * NS_PER_S)
        while bench.now_ns < end_ns:
            bench.run_for(0.001)
            timed(lambda: agent.advance(bench.now_ns))
            for end in ends:
                end.take(end.session.advance(bench.now_ns))

    _join(ends, lambda: bench.now_ns, lambda: pass_time(0.5))
    writer, reader = ends
    port = links[0].a

    def run(seconds: float) -> None:
        end_ns = bench.now_ns + round(seconds * NS_PER_S)
        while bench.now_ns < end_ns:
            while port.pending < baud // 10 // 100 and writer.has_room:
                writer.sample(size, bench.now_ns)
            pass_time(0.001)

    run(1.0)
    heard, cpu_ns[0] = reader.heard, 0
    run(seconds)
    return _rate(reader.heard - heard, seconds, cpu_ns[0], baud, frame_bytes(size, xrce.Framing.SERIAL))


def _join(ends: list[End], now_ns: Callable[[], int], wait: Callable[[], None]) -> None:
    for end in ends:
        end.take(end.session.connect(now_ns()))
    wait()
    for end in ends:
        end.create(now_ns())
    wait()
    assert [end.answers for end in ends] == [len(OBJECTS)] * 2
    ends[1].read(now_ns())
    wait()


def tcp_rate(size: int, *, reliable: bool, seconds: float) -> dict[str, Any]:
    """The same over TCP through `hilbench serve`, in real time; its CPU for each sample, in us."""
    command = [sys.executable, "-m", "hilbench", "serve", "xrce-agent", "--tcp", "0", "--tcp", "0"]
    with subprocess.Popen([*command, "--baud", str(TCP_BAUD)], stderr=subprocess.PIPE, text=True) as served:
        assert served.stderr is not None
        ports: list[int] = []
        for line in served.stderr:
            ports += [int(port) for port in re.findall(r"tcp .*:(\d+),", line)]
            if "stop with" in line:
                break
        sockets = [socket.create_connection(("127.0.0.1", port)) for port in ports]
        for one in sockets:
            one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        ends = [
            End(key, reliable=reliable, framing=xrce.Framing.LENGTH, write=one.sendall)
            for key, one in zip(KEYS, sockets, strict=True)
        ]
        reader = ends[1]
        clients = TcpClients(sockets, ends)
        _join(ends, time.monotonic_ns, lambda: clients.pass_time(0.5))
        clients.write(size, 1.0)
        heard, cpu_ns, began = reader.heard, _cpu_ns(served.pid), time.monotonic()
        clients.write(size, seconds)
        took, cpu_ns = time.monotonic() - began, _cpu_ns(served.pid) - cpu_ns
        heard = reader.heard - heard
        served.send_signal(signal.SIGINT)
        for one in sockets:
            one.close()
        served.communicate()
    return _rate(heard, took, cpu_ns, TCP_BAUD, frame_bytes(size, xrce.Framing.LENGTH))


class TcpClients:
    """Both clients at their sockets, the first of which writes."""

    def __init__(self, sockets: list[socket.socket], ends: list[End]) -> None:
        self._ends, self._writer = ends, ends[0]
        self._selector = selectors.DefaultSelector()
        for one, end in zip(sockets, ends, strict=True):
            self._selector.register(one, selectors.EVENT_READ, end)

    def pass_time(self, seconds: float) -> None:
        until = time.monotonic() + seconds
        while (left := until - time.monotonic()) > 0:
            for key, _ in self._selector.select(left):
                key.data.receive(key.fileobj.recv(65536), time.monotonic_ns())  # type: ignore[union-attr]
            for end in self._ends:
                end.take(end.session.advance(time.monotonic_ns()))

    def write(self, size: int, seconds: float) -> None:
        """Write for so long, as fast as the line takes it, and the window of a reliable stream."""
        writer, began, before = self._writer, time.monotonic(), self._writer.sent_bytes
        while (passed := time.monotonic() - began) < seconds:
            most = before + TCP_BAUD / 10 * (passed + 0.005)
            while writer.sent_bytes < most and writer.has_room:
                writer.sample(size, time.monotonic_ns())
            self.pass_time(0.0005)


def _cpu_ns(pid: int) -> int:
    """The CPU time of another process (proc(5): utime and stime)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) * NS_PER_S // os.sysconf("SC_CLK_TCK")


def _rate(heard: int, seconds: float, cpu_ns: int, baud: int, frame: int) -> dict[str, Any]:
    rate, limit = heard / seconds, baud / 10 / frame
    return {
        "rate": rate,
        "limit": limit,
        "share": rate / limit,
        "frame": frame,
        "cpu_us": cpu_ns / 1000 / max(heard, 1),
    }


# --- all of it


def parts(reconnect_count: int, deaf_count: int, seconds: float) -> Mapping[str, Callable[[], dict[str, Any]]]:
    """What is measured, by name."""
    found: dict[str, Callable[[], dict[str, Any]]] = {
        f"reconnects {way}": lambda way=way: reconnects(way, reconnect_count)  # type: ignore[misc]
        for way in WAYS
    }
    found["deaf"] = lambda: deaf(deaf_count)
    for size in (20, 200):
        for reliable in (True, False):
            kind = f"{size} {'reliable' if reliable else 'best-effort'}"
            for baud in (BAUD, 921_600):
                found[f"rate {baud} {kind}"] = lambda baud=baud, size=size, reliable=reliable: serial_rate(  # type: ignore[misc]
                    baud, size, reliable=reliable, seconds=seconds
                )
            found[f"rate tcp {kind}"] = lambda size=size, reliable=reliable: tcp_rate(  # type: ignore[misc]
                size, reliable=reliable, seconds=seconds
            )
    return found


RECONNECTS = """\
<!-- Made by `python -m measure.xrce_agent`. -->
# The agent, measured

{count} reconnects in each of six ways, with the board of `hilbench serve xrce-client` at a line of {baud} baud.
The time is bench time, to half a millisecond, from the disturbance until the agent has all objects of the board again;
those of the session before are gone. Memory is all that Python holds for agent, boards and bench (`tracemalloc`), after
a tenth of the reconnects and after all.

| What happens | Median | Longest | Memory after a tenth | After all | Kept for clients at most |
|---|---|---|---|---|---|
"""
DEAF = """
A board that is not notified finds out after {quiet_s} s without a word of the agent, by asking: that is its time, and
not the agent's.

## A client that never reads

One client writes {count} samples of 100 bytes, a hundred a second. Another one has asked for all of them on a
reliable stream, and never says anything again. The agent keeps at most {held} for both; all memory is {early} after a
tenth of the samples and {late} after all.

## Rates

Samples from one client through the agent to another one, each at a line of its own. The limit is that of the line:
frames of that length, one behind the other. CPU is the agent's for each sample: to take it, to hand it on, and the
ACKNACKs of both. Over TCP it is that of the whole program `hilbench serve`, whose sockets are paced as a line of
{tcp_baud} baud, the fastest there is.

| Line | Sample | Stream | Frame | Limit | Measured | Share of the limit | CPU |
|---|---|---|---|---|---|---|---|
"""
HOST = """
Rates at serial lines are of bench time, and no host is too slow for them. The rate over TCP and all CPU times are those
of the host that measured: meanwhile the program had {least:.0%} to {most:.0%} of a processor, beside others.
"""


def page(found: Mapping[str, Mapping[str, Any]]) -> str:
    """The page, of all parts."""
    ways = [(what, found[f"reconnects {way}"]) for way, (what, _) in WAYS.items()]
    text = RECONNECTS.format(count=ways[0][1]["count"], baud=BAUD)
    for what, one in ways:
        times = f"{one['median_ms']:.0f} ms | {one['most_ms']:.0f} ms"
        memory = " | ".join(_kib(one[name]) for name in ("memory_early", "memory_late"))
        text += f"| {what} | {times} | {memory} | {one['held']} bytes |\n"
    one = found["deaf"]
    early, late, held = (_kib(one[name]) for name in ("memory_early", "memory_late", "held"))
    quiet_s = ClientSettings().quiet_s
    text += DEAF.format(quiet_s=quiet_s, count=one["count"], held=held, early=early, late=late, tcp_baud=TCP_BAUD)
    for name, one in found.items():
        if name.startswith("rate "):
            _, line, size, stream = name.split()
            at = f"TCP, {TCP_BAUD} baud" if line == "tcp" else f"{line} baud"
            rates = f"{one['limit']:.0f}/s | {one['rate']:.0f}/s | {one['share']:.2f} | {one['cpu_us']:.0f} µs"
            text += f"| {at} | {size} bytes | {stream} | {one['frame']} bytes | {rates} |\n"
    busy = [one["rate"] * one["cpu_us"] / 1e6 for name, one in found.items() if name.startswith("rate tcp")]
    return text + HOST.format(least=min(busy), most=max(busy))


def _kib(count: int) -> str:
    return f"{count / 1024:.0f} KiB"


def main(words: list[str]) -> int:
    """Measure what is not measured yet, and write the page."""
    parser = argparse.ArgumentParser(prog="python -m measure.xrce_agent", description=__doc__)
    parser.add_argument("--again", action="store_true", help="measure everything")
    parser.add_argument("--reconnects", type=int, default=1000, help="in each way (default: 1000)")
    parser.add_argument("--docs", type=Path, default=DOCS, help="where the page goes")
    chosen = parser.parse_args(words)
    kept = chosen.docs / "measured.json"
    found = {} if chosen.again or not kept.exists() else json.loads(kept.read_text(encoding="utf-8"))
    wanted = parts(chosen.reconnects, 20_000, 5.0)
    for name, measure in wanted.items():
        if name not in found:
            found[name] = measure()
            sys.stdout.write(f"{name}: {found[name]}\n")
            sys.stdout.flush()
            kept.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    (chosen.docs / "measured.md").write_text(page({name: found[name] for name in wanted}), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
