"""A participant of a DDS domain in a process of its own: programs of the Python binding, with types that it knows.

python dds_peer.py ROLE ...        each line that it prints is something that happened; it ends with its input
"""

from __future__ import annotations

import sys
import threading
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float32, int64, uint64
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

RELIABLE = Policy.Reliability.Reliable(duration(seconds=1))
KEPT = Qos(RELIABLE, Policy.Durability.TransientLocal, Policy.History.KeepLast(16))
PLAIN = Qos(RELIABLE, Policy.Durability.Volatile, Policy.History.KeepLast(16))


@dataclass
class Float32(IdlStruct, typename="std_msgs.msg.dds_.Float32_"):
    data: float32


@dataclass
class Request(IdlStruct, typename="example_interfaces.srv.dds_.AddTwoInts_Request_"):
    guid: uint64
    seq: int64
    a: int64
    b: int64


@dataclass
class Response(IdlStruct, typename="example_interfaces.srv.dds_.AddTwoInts_Response_"):
    guid: uint64
    seq: int64
    sum: int64


def hear(reader, heard):
    """Calls `heard` with each sample, in a thread of Python's: a listener waits for the interpreter while it holds up
    Cyclone DDS, which a writer of this binding waits for while it holds up the interpreter."""
    threading.Thread(target=lambda: [heard(sample) for sample in reader.take_iter()], daemon=True).start()


def said(*words):
    sys.stdout.write(" ".join(map(str, words)) + "\n")
    sys.stdout.flush()


def node(participant, topic):
    """Prints what it hears, and writes each line that it reads."""
    where = Topic(participant, topic, Float32)
    hear(DataReader(participant, where, KEPT), lambda sample: said("heard", sample.data))
    writer = DataWriter(participant, where, KEPT)
    for line in sys.stdin:
        writer.write(Float32(float(line)))


def misfit(participant, topic, kind):
    """A writer or reader that suits no reliable one, or none that keeps samples."""
    best_effort = Qos(Policy.Reliability.BestEffort)
    made = {
        "best-effort": lambda: DataWriter(participant, Topic(participant, topic, Float32), best_effort),
        "wanting": lambda: DataReader(participant, Topic(participant, topic, Float32), KEPT),
    }[kind]()
    sys.stdin.read()
    del made


def server(participant, name):
    """Adds."""
    writer = DataWriter(participant, Topic(participant, f"rr/{name}Reply", Response), PLAIN)

    def add(asked):
        said("asked", asked.a, asked.b)
        writer.write(Response(asked.guid, asked.seq, asked.a + asked.b))

    hear(DataReader(participant, Topic(participant, f"rq/{name}Request", Request), PLAIN), add)
    sys.stdin.read()


def caller(participant, name):
    """Asks for each line that it reads, again each second until it is answered."""
    answered = threading.Event()

    def heard(sample):
        if sample.guid == 42:
            said("answered", sample.seq, sample.sum)
            answered.set()

    hear(DataReader(participant, Topic(participant, f"rr/{name}Reply", Response), PLAIN), heard)
    writer = DataWriter(participant, Topic(participant, f"rq/{name}Request", Request), PLAIN)
    for number, line in enumerate(sys.stdin):
        answered.clear()
        while not answered.wait(1):
            writer.write(Request(42, number, *map(int, line.split())))


if __name__ == "__main__":
    {"node": node, "misfit": misfit, "server": server, "caller": caller}[sys.argv[1]](
        DomainParticipant(0), *sys.argv[2:]
    )
