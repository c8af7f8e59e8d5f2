"""The pages of docs/xrce that are made from the code, for `generate.py`."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence

from protocols import xrce
from protocols.common.clause import Clause
from protocols.xrce.clauses import CLAUSES

TableMaker = Callable[[Sequence[str], Iterable[Sequence[str]]], str]
IDS = {"request_id": 10, "object_id": 0x15}
EXAMPLES = (
    xrce.CreateClient(client=xrce.Client(client_key=bytes.fromhex("AABBCCDD"), session_id=0x81, mtu=512)),
    xrce.StatusAgent(status=xrce.Status.OK, agent=xrce.Agent()),
    xrce.Create(
        request_id=11,
        object_id=0x12,
        object=xrce.Topic(
            representation=xrce.TopicBinary(topic_name="rt/speed", type_name="std_msgs::msg::dds_::Float32_"),
            participant_id=0x11,
        ),
    ),
    xrce.StatusReply(request_id=11, object_id=0x12, status=xrce.Status.OK),
    xrce.WriteData(**IDS, data=bytes.fromhex("0000A040")),
    xrce.AckNack(first_unacked=5, nack_bitmap=0x0103, stream_id=0x80),
    xrce.Heartbeat(first_unacked=5, last_unacked=9, stream_id=0x80),
    xrce.GetInfo(request_id=10, object_id=xrce.OBJECT_AGENT, info_mask=xrce.InfoMask.ACTIVITY),
)


def states_page(machine: Callable[[str, xrce.Table], str]) -> str:
    """The state machines of both roles."""
    return (
        "# The state machines of a DDS-XRCE session\n\n"
        "Both are data in `protocols/xrce/states.py`. A pair of state and trigger without an edge changes nothing and "
        "is counted. What a message of a stream does that came twice, too early or not at all is arithmetic, and "
        "stands in `protocols/xrce/streams.py`.\n\n"
        + machine("The client", xrce.CLIENT_TABLE)
        + "\n"
        + machine("The agent", xrce.AGENT_TABLE)
    )


def clauses_page(suites: Callable[[Sequence[Clause]], str]) -> str:
    """Every clause."""
    return (
        "# What an agent of DDS-XRCE must do, and a client\n\n"
        "`hilbench check xrce-agent` checks our agent; with `--target serial:PORT` or `--target socket://HOST:PORT` it "
        "checks another one that takes serial frames there. The checker is its client. `hilbench check xrce-client` "
        "checks a client, too, and the checker is its agent. A *should* that fails warns, and fails with "
        "`--strict`.\n\n" + suites(CLAUSES)
    )


def submessages_page(table: TableMaker) -> str:
    """Every submessage and kind of object, and some of them byte by byte."""
    submessages = [
        (str(int(number)), number.name, f"`{kind.__name__}`", _fields(kind), _first_line(kind))
        for kind, number in xrce.SUBMESSAGES.items()
    ]
    objects = [
        (f"`{int(number):X}`", number.name, f"`{kind.__name__}`", _fields(kind))
        for kind, number in xrce.KIND_OF_OBJECT.items()
    ]
    examples = [(f"`{one}`", f"`{xrce.encode_submessage(one).hex(' ').upper()}`") for one in EXAMPLES]
    return (
        "# What is said in DDS-XRCE\n\n"
        "A submessage is its id, a byte of flags, the length of its payload (16 bits, little-endian) and the payload; "
        "bit 0 of the flags says that numbers in it are little-endian. Units and meanings of the fields stand at the "
        "classes in `protocols/xrce/submessages.py`.\n\n"
        + table(("Id", "Name", "Class", "Fields", "What it is"), submessages)
        + "\n## Kinds of objects\n\n"
        "The kind is the last four bits of an object's id. A representation is `ByReference`, `AsXml`, or the kind's "
        "own class in binary.\n\n"
        + table(("Kind", "Name", "Class", "Fields"), objects)
        + "\n## Worked out\n\n"
        + table(("Submessage", "Bytes"), examples)
    )


def _fields(kind: type) -> str:
    return ", ".join(f"`{field.name}`" for field in dataclasses.fields(kind)) or "none"


def _first_line(kind: type) -> str:
    return (kind.__doc__ or "").partition("\n")[0]
