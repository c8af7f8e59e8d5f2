"""The two records that hilbench finds, the bus and the head, and the rules that a head has to follow."""

from pathlib import Path
from types import MappingProxyType

from hilbench.plugins.dashboard import Dashboard
from hilbench.plugins.protocol import API, Device, ProtocolPlugin, Recorded
from hilbench.protocol_bench.system import ProtocolSystem
from pantilt.body import kind
from pantilt.frames import IDS, LONGEST, FrameError, Torque, decode, encode, look
from pantilt.head import Head, Settings
from pantilt.host import Host
from protocols.common.clause import Clause
from protocols.common.decoding import ReaderDecoder, message_item
from protocols.common.framing import Dropped, ScanningReader

RULES = {
    "PT1": "answers: A servo answers each command that has its id within 20 ms, and answers with its id.",
    "PT2": "goal: A joint is within 0.5 degrees of its goal after the way at 60 degrees/s and 0.6 s, and stays there.",
    "PT3": "position: Status says where the joint is, within 1 degree, also on the way.",
    "PT4": "limits: A goal beyond 90 degrees of pan or 60 of tilt is refused and changes nothing.",
    "PT5": "checksum: A frame with a wrong checksum is not answered, and the next sound one is.",
    "PT6": "ids: A command moves the joint of its id alone; an id that nobody has is not answered.",
    "PT7": "watchdog: A servo lets go 1 s after the last command, give or take 50 ms; the next Status says so.",
    "PT8": "torque: Without torque a goal is refused, and a servo that gets torque holds where it is.",
    "PT9": "load: A servo that is blocked says a load of at least 90 %, and where it is.",
}
IN_WORLD = {"PT2", "PT3", "PT6", "PT9"}  # judged by the truth


def clauses():
    about = {"level": "must", "sources": ("examples/pantilt/README.md",), "suite": "pantilt-rules"}
    rules = ((name, ("truth",) if name in IN_WORLD else (), *rule.split(": ", 1)) for name, rule in RULES.items())
    return [Clause(id=name, needs=needs, title=title, text=text, **about) for name, needs, title, text in rules]


def decoder(options, speaker):
    return ReaderDecoder(ScanningReader(look), rejected=Dropped, senseless=FrameError, body="payload", item=item)


def item(frame):
    return message_item(frame, decode(frame))


BUS = ProtocolPlugin(
    api=API,
    name="pantilt",
    title="Pan-tilt bus",
    summary="a head that pans and tilts, on a bus of two servos",
    decoder=decoder,
    encode=encode,
    answers=dict.fromkeys(("Goal", "Read", "Torque"), ("Status", "Refused")),
    clauses=clauses,
    longest_frame=LONGEST + 4,
    baud=115200,
    device=Device(make=Head, settings=Settings),
    host=Device(make=Host, resting=frozenset({"TURN"})),
    settle=lambda peer: [peer.send(Torque(servo, False)) for servo in IDS.values()],
    suites=(Path(__file__).with_name("pantilt_rules.py"),),
    recorded=Recorded(suites=(str(Path(__file__).with_name("pantilt_recorded.py")),)),
)


def view(told, width, height):
    """Return a scale for each joint with where it is, left or down to right or up."""
    from rich.text import Text

    wide = max(9, min(61, width - 16))
    places = {joint: round((told[joint] + 90) / 180 * (wide - 1)) for joint in IDS}
    return [Text(f"{joint:<5}{'▲'.rjust(at + 1, '─'):─<{wide}} {told[joint]:+5.1f}°") for joint, at in places.items()]


class PanTilt(ProtocolSystem):
    """The head as a system: what checks, serves and shows its bus finds it in a world."""

    summary = BUS.summary
    vehicles = MappingProxyType({"pantilt": kind})
    benches = Path(__file__).with_name("benches")

    def dashboard(self):
        return Dashboard(kind="pantilt", shows=frozenset({"pantilt"}), tells="pantilt", view=view, plots=("angle",))


PANTILT = PanTilt(BUS, has_body=True)
