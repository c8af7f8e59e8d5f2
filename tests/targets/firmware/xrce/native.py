"""The client in C, built for the host, at one end of a line whose other end is our agent."""

from __future__ import annotations

import collections
import ctypes
import enum
import heapq
import itertools
import subprocess
from pathlib import Path
from typing import ClassVar

from protocols import xrce
from protocols.testing import LATENCY_NS, unchanged
from targets import firmware

MS = 1_000_000
SECOND = 1000 * MS
FLOAT = "std_msgs::msg::dds_::Float32_"
UP, DOWN, UP_BEST, DOWN_BEST, SERVICE = range(5)
FLAGS = ["-std=gnu17", "-O1", "-g", "-Wall", "-Wextra", "-Werror", "-Wstrict-prototypes", "-Wshadow", "-Wundef"]
ROOM = 1 << 20
MOST_HEARD, WHOLE = 256, 1024
HERE = Path(__file__).parent


class State(enum.IntEnum):
    """Of the client."""

    SEEKING = 0
    ASKING = 1
    CREATING = 2
    OPEN = 3


class Heard(ctypes.Structure):
    """A sample, as the harness keeps it."""

    _fields_ = (
        ("endpoint", ctypes.c_uint32),
        ("count", ctypes.c_uint32),
        ("big_endian", ctypes.c_uint32),
        ("data", ctypes.c_uint8 * WHOLE),
    )


def compiled(made, *words, harness="harness.c"):
    """Compile the client with a harness; return the file."""
    root = Path(firmware.__file__).parent
    sources = [*sorted((root / "xrce").glob("*.c")), HERE / harness]
    subprocess.run(["gcc", *FLAGS, *words, f"-I{root}", *map(str, sources), "-o", str(made)], check=True)
    return made


def loaded(made):
    """Load a file that was compiled to be shared."""
    library = ctypes.CDLL(str(made))
    library.write_sample.argtypes = (ctypes.c_uint32, ctypes.c_char_p, ctypes.c_uint32, ctypes.c_uint32)
    library.receive.argtypes = (ctypes.c_char_p, ctypes.c_uint32, ctypes.c_uint32)
    library.advance.restype = ctypes.c_uint32
    return library


def build(folder):
    """Compile the client with its harness; return the library."""
    return loaded(compiled(folder / "xrce.so", "-shared", "-fPIC"))


class Native:
    """The client, and an agent that may be put in another's place.

    Args:
        library: with the client, and what uses it.
        damage: what the line does to each write.
        options: of the agent.
        domain_id: of the client's participant.
        start_ms: what the client's clock says at the begin.
        lost_s: how long an agent may be silent until it is lost.
        answers_after_ns: how much longer than usual what the agent writes is under way.

    Attributes:
        WRITTEN: topics that nodes beside the agent write, with their types.
        READ: topics that they read.
        agent: the one at the line; None for nobody.
        heard: by endpoint, what the client has heard.
        said: by topic, what nodes beside the agent have heard.
        written: all that the client has written.
        came: each write that has come to it.
    """

    WRITTEN: ClassVar = {
        "rt/down": FLOAT,
        "rt/down_best": FLOAT,
        "rq/askRequest": "std_srvs::srv::dds_::SetBool_Request_",
    }
    READ: ClassVar = {"rt/up": FLOAT, "rt/up_best": FLOAT, "rr/askReply": "std_srvs::srv::dds_::SetBool_Response_"}

    def __init__(
        self, library, *, damage=unchanged, options=None, domain_id=0, start_ms=0, lost_s=10, answers_after_ns=0
    ):
        self._library = library
        self._answers_after_ns = answers_after_ns
        self._options = options
        self._out = ctypes.create_string_buffer(ROOM)
        self._kept = (Heard * MOST_HEARD)()
        self._flying = []
        self._order = itertools.count()
        self._due_ns = 0
        self.damage = damage
        self.now_ns = start_ms * MS
        self.domain_id = domain_id
        self.heard = collections.defaultdict(list)
        self.said = {topic: [] for topic in self.READ}
        self.written = b""
        self.came = []
        self.agent = None
        self.restart_agent()
        library.begin(domain_id, round(lost_s * 1000), self._now_ms)

    # --- what a test does

    def restart_agent(self):
        """Put a new agent at the line, which knows nothing; nodes beside it write and read."""
        self.agent = agent = xrce.AgentService(("board",), self._options)
        self._writers = {
            topic: agent.writer(topic, kind, domain_id=self.domain_id) for topic, kind in self.WRITTEN.items()
        }
        for topic, kind in self.READ.items():
            agent.listen(topic, kind, self.said[topic].append, domain_id=self.domain_id)

    def write(self, endpoint, data):
        """The client's program writes; whether it could."""
        done = self._library.write_sample(endpoint, data, len(data), self._now_ms)
        self._fetch()
        return bool(done)

    def publish(self, topic, data, identity=None):
        """A node beside the agent writes, a request with its identity."""
        self._wrote(self.agent.write(self._writers[topic], data, self.now_ns, identity=identity))

    def end(self):
        """The client's program ends the session."""
        self._library.end(self._now_ms)
        self._fetch()

    def number_from(self, number):
        """Have both ends of the reliable stream, on which nothing is under way, go on with another number."""
        self._library.number_from(number)
        streams = self.agent.sessions["board"]._machine.streams
        streams.reliable_output(0x80)._first = number
        taken = streams.reliable_input(0x80)
        taken._expected, taken._latest = number, xrce.after(number, -1)

    def to_client(self, data):
        """Bytes come to the client now."""
        self._library.receive(data, len(data), self._now_ms)
        self._step()

    def pass_over(self, duration_ns):
        """Let time pass without a call of the client, or anything from the agent."""
        self.now_ns += duration_ns
        self._due_ns = self.now_ns

    def run(self, duration_ns):
        """Let time pass."""
        end_ns = self.now_ns + duration_ns
        while (next_ns := self._next_ns()) <= end_ns:
            self.now_ns = max(next_ns, self.now_ns)
            while self._flying and self._flying[0][0] <= self.now_ns:
                _, _, end, data = heapq.heappop(self._flying)
                if end == "client":
                    self.came.append(data)
                    self._library.receive(data, len(data), self._now_ms)
                elif self.agent is not None:
                    self._wrote(self.agent.receive("board", data, self.now_ns))
            if self.agent is not None:
                self._wrote(self.agent.advance(self.now_ns))
            self._step()
        self.now_ns = end_ns

    # --- what is seen

    @property
    def state(self):
        """Of the client."""
        return State(self._library.state())

    @property
    def unacknowledged(self):
        """Messages of the client."""
        return self._library.unacknowledged()

    @property
    def objects(self):
        """The ids of what the client has at the agent."""
        return {*self.agent.objects["board"]}

    @property
    def _now_ms(self):
        return (self.now_ns // MS) & 0xFFFFFFFF

    def _next_ns(self):
        times = [self._flying[0][0]] if self._flying else []
        agent_ns = self.agent.next_deadline_ns() if self.agent is not None else None
        return min([*times, self._due_ns, *([] if agent_ns is None else [agent_ns])])

    def _step(self):
        wait_ms = self._library.advance(self._now_ms)
        self._fetch()
        self._due_ns = (self.now_ns // MS + max(1, wait_ms)) * MS

    def _fetch(self):
        count = self._library.take_out(self._out)
        if count:
            self.written += self._out.raw[:count]
            self._fly("agent", self._out.raw[:count])
        count = self._library.take_heard(self._kept)
        assert count <= MOST_HEARD
        for one in self._kept[:count]:
            self.heard[one.endpoint].append(bytes(one.data[: one.count]))

    def _wrote(self, written):
        for _, data in written:
            self._fly("client", data)

    def _fly(self, end, data):
        data = self.damage(data)
        latency_ns = LATENCY_NS + (self._answers_after_ns if end == "client" else 0)
        if data:
            heapq.heappush(self._flying, (self.now_ns + latency_ns, next(self._order), end, data))
