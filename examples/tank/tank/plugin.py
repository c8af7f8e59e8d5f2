"""The record that hilbench finds, and the rules that a node has to follow."""

from pathlib import Path

from hilbench.plugins.protocol import API, Device, ProtocolPlugin, Recorded
from protocols.common.clause import Clause
from protocols.common.decoding import ReaderDecoder, message_item
from protocols.common.framing import Dropped, ScanningReader
from tank.frames import CHECKSUM, LONGEST, FrameError, SetValve, decode, encode, look
from tank.host import Host
from tank.node import Node, Settings

RULES = {
    "TANK1": "Read: A node answers Read with its level within 50 ms.",
    "TANK2": "the valve: SetValve opens the valve by its per cent, and is answered with what is so then.",
    "TANK3": "refusals: What makes no sense, or opens by more than 100 %, is refused and changes nothing.",
    "TANK4": "CRC: A frame with a wrong CRC is not answered, and the next sound one is.",
    "TANK5": "watchdog: An open valve shuts 1 s after the last command, give or take 50 ms; the next answer says so.",
}


def clauses():
    about = {"level": "must", "sources": ("examples/tank/README.md",), "suite": "tank"}
    return [Clause(id=name, title=it.split(": ")[0], text=it.split(": ")[1], **about) for name, it in RULES.items()]


def decoder(options, speaker):
    return ReaderDecoder(ScanningReader(look), rejected=Dropped, senseless=FrameError, body="payload", item=item)


def item(frame):
    return message_item(frame, decode(frame.payload))


TANK = ProtocolPlugin(
    api=API,
    name="tank",
    title="Tank bus",
    summary="level and valve of a water tank",
    decoder=decoder,
    encode=encode,
    answers={"Read": ("Level",), "SetValve": ("Level", "Refused")},
    clauses=clauses,
    checksum=lambda options: CHECKSUM,
    longest_frame=LONGEST + 3,
    baud=115200,
    device=Device(make=Node, settings=Settings),
    host=Device(make=Host, resting=frozenset({"ASK"})),
    settle=lambda peer: peer.send(SetValve(0)),
    suites=(Path(__file__).with_name("suite.py"),),
    recorded=Recorded(suites=(str(Path(__file__).with_name("recorded.py")),)),
)
