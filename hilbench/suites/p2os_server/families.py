"""Whole families of stimuli, each tried member by member: every bit of a checksum, every byte in an argument."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hilbench.check import Violation, at_most, case, try_members
from hilbench.clock import NS_PER_S
from hilbench.judging.uncertainty import OfTimes
from hilbench.suites._session import Session
from hilbench.suites._spoiling import WrongByte, other_rules, other_values, single_bits
from hilbench.systems.pioneer.cases import AttachedCase, VirtualCase
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import HEADER, MAX_COUNT_STRICT, CommandNumber, ConfigPacket, Sip, encode_frame

_C = CommandNumber

BODY_AT = len(HEADER) + 1
CHECKSUM = ("checksum byte 1", "checksum byte 2")
POSITIVE = 0x3B
ANSWER_S = 0.25
"""How long a CONFIG may take on a slow line, with a SIP before it."""


def shown(session: Session, frame: bytes) -> Sip:
    """Send a frame; return the second SIP behind it: what a robot was about to say may be older."""
    arrived_ns = session.write(frame)
    if baud := session.peer.port.baud:  # where it is handed over late, all of it may still be to come
        arrived_ns = max(arrived_ns, session.now_ns + 10 * len(frame) * NS_PER_S // baud)
    return [session.next_after(arrived_ns).sip for _ in range(2)][-1]


def _body_and_checksum(frame: bytes) -> Mapping[int, str]:
    """Name the bytes of a frame behind its count, by their places."""
    body = [f"byte {number} of the body" for number in range(1, len(frame) - BODY_AT - 1)]
    return dict(enumerate((*body, *CHECKSUM), start=BODY_AT))


def _checksum(frame: bytes) -> Mapping[int, str]:
    return dict(enumerate(CHECKSUM, start=len(frame) - 2))


@case("S59", bench_time_s=9.1)
def test_every_bit_of_a_checksum_counts(bench: VirtualCase | AttachedCase, peer: Peer) -> None:
    """ENABLE 1 would show within two SIPs, CONFIG would be answered. The right ENABLE 1 is obeyed in the end."""
    session, seed = Session(peer), bench.case.seed

    def is_not_obeyed(wrong: WrongByte) -> None:
        frame_is_not_obeyed(wrong.put_into(enable))

    def frame_is_not_obeyed(frame: bytes) -> None:
        if shown(session, frame).motors_enabled:
            raise Violation("an ENABLE 1 with a wrong checksum was obeyed", peer.evidence())

    def is_not_answered(wrong: WrongByte) -> None:
        mark = peer.mark()
        session.write(wrong.put_into(config))
        peer.run(ANSWER_S)
        if peer.since(mark, ConfigPacket):
            raise Violation("a CONFIG with a wrong checksum was answered", peer.evidence(mark))

    enable, config = (encode_frame(bytes((number, POSITIVE, 1, 0))) for number in (_C.ENABLE, _C.CONFIG))
    corrupted = single_bits(enable, _body_and_checksum(enable))
    try_members("single bits", corrupted, is_not_obeyed, seed=seed, budget=20)
    corrupted = other_values(enable, _checksum(enable), HEADER[:1])
    try_members("wrong bytes of a checksum", corrupted, is_not_obeyed, seed=seed, budget=10)
    others = other_rules(enable, peer.checksum())
    try_members("checksums by another rule", others, frame_is_not_obeyed, seed=seed, budget=len(others))
    corrupted = [
        *single_bits(config, _body_and_checksum(config)),
        *other_values(config, _checksum(config), HEADER[:1]),
    ]
    try_members("corrupted requests", corrupted, is_not_answered, seed=seed, budget=8)
    session.motors_on()
    session.leave()


FLOW_CONTROL = {0x11: "XON", 0x13: "XOFF"}
OF_FRAMES = {0xFA: "FA", 0xFB: "FB", 0x3B: "3B", 0x1B: "1B", 0x2B: "2B"}


def _digout(mask: int, value: int) -> bytes:
    """Return a DIGOUT as Player packs it."""
    return encode_frame(bytes((_C.DIGOUT, POSITIVE, value, mask)))


def _places(names: Mapping[int, str]) -> list[tuple[str, tuple[int, int]]]:
    """Return masks and values of DIGOUTs in which these bytes stand at each place where one may."""
    found = []
    for byte, name in names.items():
        found += [(f"{name} as the value", (0xFF, byte)), (f"{name} as the mask", (byte, byte))]
        for place, of_checksum in ((-2, "high"), (-1, "low")):
            same = [mask for mask in range(1, 256) if _digout(mask, mask)[place] == byte]
            found += [(f"{name} as the checksum's {of_checksum} byte", (mask, mask)) for mask in same]
    return found


@case("S60", bench_time_s=8.6)
def test_no_byte_is_special_inside_a_packet(bench: VirtualCase | AttachedCase, peer: Peer) -> None:
    """Where the outputs are already as asked for, they are made to differ first."""
    session = Session(peer)
    before = now = session.first.sip.digout

    def set_outputs(mask: int, value: int) -> int:
        return shown(session, _digout(mask, value)).digout

    def are_set(mask_and_value: tuple[int, int]) -> None:
        nonlocal now
        mask, value = mask_and_value
        if not (now ^ value) & mask:
            now = set_outputs(0xFF, ~value & 0xFF)
        due = now & ~mask | value & mask
        now = set_outputs(mask, value)
        if now != due:
            raise Violation(f"the outputs are {now:02X} after mask {mask:02X} and value {value:02X}, not {due:02X}")

    families = (
        ("flow-control bytes", _places(FLOW_CONTROL), 8),
        ("bytes of packets", [*_places(OF_FRAMES), ("FA FB", (0xFB, 0xFA))], 10),
        ("other values", [(f"value {value:02X}", (0xFF, value)) for value in range(256)], 10),
    )
    try:
        for family, members, budget in families:
            try_members(family, members, are_set, seed=bench.case.seed, budget=budget)
    finally:  # something may hang on the outputs of a real robot
        session.write(_digout(0xFF, before))
    session.leave()


@case("S63", bench_time_s=6.2)
def test_bytes_behind_an_argument_are_ignored(bench: VirtualCase | AttachedCase, peer: Peer) -> None:
    """Each one switches over what a SIP shows; what follows the argument says the contrary."""
    session = Session(peer)
    flags = session.first.sip.flags

    def is_obeyed(number_flag_and_more: tuple[int, int, int]) -> None:
        nonlocal flags
        number, flag, more = number_flag_and_more
        on = not flags & flag
        contrary = bytes((not on,)) * more
        due = flags ^ flag
        flags = shown(session, encode_frame(bytes((number, POSITIVE, on, 0)) + contrary)).flags
        if (flags ^ due) & flag:
            raise Violation(f"the flags are {flags:02X}: it was not obeyed", peer.evidence())

    members = [
        (f"{name}, bytes too many: {more}", (number, flag, more))
        for name, number, flag in (("ENABLE", _C.ENABLE, 1), ("SONAR", _C.SONAR, 2))
        for more in range(1, MAX_COUNT_STRICT - 5)
    ]
    try_members("sizes too large", members, is_obeyed, seed=bench.case.seed, budget=20)
    session.send(_C.SONAR, 1)
    session.leave()


@case("S61", bench_time_s=4.4)
def test_a_session_after_another_has_its_sips_once(peer: Peer) -> None:
    counts, begun_ns = [], peer.bench.now_ns
    for _ in range(3):
        session = Session(peer)
        counts.append(len(session.watch(1.0)))
        session.leave()
        peer.run(0.3)
    _require_once(counts, peer, begun_ns)


@case("S62", bench_time_s=3.2)
def test_a_client_that_comes_back_has_its_sips_once(bench: VirtualCase | AttachedCase, peer: Peer) -> None:
    counts, begun_ns = [], peer.bench.now_ns
    for again in (True, False):
        session = Session(peer)
        counts.append(len(session.watch(1.0)))
        if again:
            bench.hang_up()
            peer.run(0.3)
            bench.reconnect()
            peer.settle()  # a robot at a serial line knows nothing of it, and is still in session
    session.leave()
    _require_once(counts, peer, begun_ns)


def _require_once(counts: Sequence[int], peer: Peer, begun_ns: int) -> None:
    """Require no more SIPs in a second of each session than in one of the first."""
    doubt = counts[0] * peer.uncertainty_s(begun_ns)
    for number, count in enumerate(counts[1:], start=2):
        what = f"in one second of session {number}"
        at_most(count, 1.5 * counts[0], unit="SIPs", what=what, uncertainty=OfTimes(doubt) if doubt else 0.0)
