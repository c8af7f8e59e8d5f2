"""Endpoints by the C interface of Cyclone DDS: two participants of one process, who find each other at once."""

from __future__ import annotations

import contextlib
import importlib.util

import pytest

from tests.each import each

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("cyclonedds") is None, reason="the extra 'ros2' is not installed"
)
FLOAT = "std_msgs::msg::dds_::Float32_"


@pytest.fixture
def make(domain, monkeypatch):
    """Makes endpoints, of the first participant or the second one."""
    from hilbench.systems.xrce_agent.cyclone import Endpoint, Participant, Watch

    for name, value in domain.items():
        monkeypatch.setenv(name, value)
    with contextlib.ExitStack() as stack:
        watch = Watch()
        stack.callback(watch.close)
        both = [Participant(watch, 0) for _ in range(2)]
        for one in both:
            stack.callback(one.close)

        def made(topic, type_name=FLOAT, *, of=0, writes=True, reliable=True, durability=1, depth=16):
            asked = {"writes": writes, "reliable": reliable, "durability": durability, "depth": depth}
            return Endpoint(both[of], topic, type_name, **asked)

        yield made


def test_samples_of_any_length_arrive_as_they_are(make):
    writer, reader = make("rt/any"), make("rt/any", of=1, writes=False)
    for length in (0, 1, 2, 3, 4, 1397, 65533, 1_000_001):
        data = bytes(range(1, 256)) * (length // 255 + 1)
        writer.write(data[:length])
        assert [*reader.take()] == [data[:length]], length


def test_all_that_came_are_taken_in_order(make):
    writer, reader = make("rt/many", depth=200), make("rt/many", of=1, writes=False, depth=200)
    for count in (1, 63, 64, 65, 128, 200):
        said = [bytes((number,)) for number in range(count)]
        for one in said:
            writer.write(one)
        assert [*reader.take()] == said


def test_who_writes_does_not_hear_itself(make):
    writer, reader = make("rt/own"), make("rt/own", writes=False)
    writer.write(bytes(4))
    assert [*reader.take()] == []


def test_two_types_of_one_topic_are_apart(make):
    of_one, of_other = (make("rt/two", kind, of=1, writes=False) for kind in ("a::A_", "a::B_"))
    make("rt/two", "a::B_").write(b"abcd")
    assert ([*of_one.take()], [*of_other.take()]) == ([], [b"abcd"])


@each("name", ["", "rt/a b", "rt/\udcff", "rt/a\0b", "rt/\x1b[1m", "rt/ä", "rt/*", "a" * 257, "a" * 70000])
def test_a_name_that_dds_does_not_have_is_refused(make, name):
    from hilbench.systems.xrce_agent.cyclone import DdsError

    for names in ((name, FLOAT), ("rt/a", name)):
        with pytest.raises(DdsError, match="is no name in DDS") as caught:
            make(*names)
        assert str(caught.value).isprintable()
        assert len(str(caught.value)) < 100
    make("a" * 256, "b" * 256).close()


BINDING = {
    "reliability": ("reader", lambda of: of.Reliability.Reliable(0)),
    "data representation": (
        "reader",
        lambda of: of.DataRepresentation(use_cdrv0_representation=False, use_xcdrv2_representation=True),
    ),
    "deadline": ("reader", lambda of: of.Deadline(10**9)),
    "latency budget": ("writer", lambda of: of.LatencyBudget(10**9)),
    "ownership": ("reader", lambda of: of.Ownership.Exclusive),
    "liveliness": ("reader", lambda of: of.Liveliness.Automatic(10**9)),
    "destination order": ("reader", lambda of: of.DestinationOrder.BySourceTimestamp),
    "presentation": ("subscriber", lambda of: of.PresentationAccessScope.Topic(True, False)),
}


@each(("name", "end", "policy"), [(name, *how) for name, how in BINDING.items()])
def test_what_does_not_suit_has_a_name(make, name, end, policy):
    from cyclonedds.core import Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader, Subscriber
    from cyclonedds.topic import Topic

    from tests.hilbench.systems.xrce_agent.dds_peer import Float32

    topic = f"rt/{name.replace(' ', '_')}"
    ours = make(topic, reliable=False, writes=end != "writer", durability=0)
    participant = DomainParticipant(0)
    asked, there = Qos(policy(Policy)), Topic(participant, topic, Float32)
    theirs = {
        "reader": lambda: DataReader(participant, there, asked),
        "writer": lambda: DataWriter(participant, there, asked),
        "subscriber": lambda: DataReader(Subscriber(participant, asked), there),
    }[end]()
    assert (ours.mismatch(), ours.mismatch()) == (name, "")
    del theirs
