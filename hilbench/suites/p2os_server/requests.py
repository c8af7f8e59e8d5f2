"""What is sent or set on request, and commands of other robots."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.check import Inconclusive, Violation, at_least, at_most, case, near
from hilbench.suites._requirements import require_request
from hilbench.suites._session import CYCLE_S, SIP_WITHIN_S, Session, poses
from hilbench.systems.pioneer.cases import VirtualCase
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber, ConfigPacket, EncoderPacket, IoPacket, Sip, pack_bytes

_C = CommandNumber


@case("S42", bench_time_s=1.2)
def test_configuration_is_sent_on_request(peer: Peer) -> None:
    session = Session(peer)
    for argument in (1, None):
        mark = peer.mark()
        session.send(_C.CONFIG, argument)
        peer.run(0.5)
        configs = [config for _, config in peer.since(mark, ConfigPacket)]
        assert len(configs) == 1, f"{len(configs)} CONFIG packets came, required one"
        reached = configs[0].fields
        assert reached >= ConfigPacket.P2OS_FIELDS, (
            f"only {reached} fields, not {ConfigPacket.P2OS_FIELDS} up to TransKI"
        )
    session.leave()


@case("S43", bench_time_s=2.2)
def test_encoders_are_sent_on_request(peer: Peer) -> None:
    require_request(peer, _C.ENCODER, EncoderPacket)


@case("S44", bench_time_s=2.2)
def test_inputs_and_outputs_are_sent_on_request(peer: Peer) -> None:
    require_request(peer, _C.IOREQUEST, IoPacket)


Ticks = tuple[int, int]
"""Of the left and of the right wheel."""


def _ticks(packet: EncoderPacket) -> Ticks:
    return packet.left_ticks, packet.right_ticks


def _turned(start: Ticks, end: Ticks) -> Ticks:
    return end[0] - start[0], end[1] - start[1]


@case("S87", bench_time_s=5.4)
def test_encoders_follow_the_wheels(peer: Peer) -> None:
    """Drives straight and turns on the spot. Floor: 0.6 m ahead."""
    session = Session(peer, motors=True)
    session.set_ramps(up=300, down=300, turn=100)
    session.send(_C.SETO)
    session.send(_C.ENCODER, 2)
    session.next()
    start, _ = peer.expect(EncoderPacket, SIP_WITHIN_S, what="encoder packet"), session.next()
    mark, first = peer.mark(), session.next()
    session.send(_C.VEL, 200)
    session.watch_alive(1.8)
    session.send(_C.STOP)
    session.wait_at_rest(4.0)
    stopped = peer.expect(EncoderPacket, SIP_WITHIN_S, what="encoder packet")
    way_mm = poses([first, session.next()], session.robot)[-1].x_mm
    ahead = _turned(_ticks(start), _ticks(stopped))
    if way_mm < LEAST_WAY_MM:
        raise Inconclusive(
            f"by its SIPs the robot has gone {way_mm:.0f} mm ahead: nothing to hold its encoders against"
        )
    if min(ahead) <= 0:
        raise Violation(f"the ticks go by {ahead[0]} and {ahead[1]} on a way ahead", peer.evidence())
    at_least(
        min(ahead) / max(ahead), 1 - WHEELS, unit="", what=f"ticks {ahead} on a straight way, one beside the other"
    )
    _require_in_step(session, mark, _ticks(start), ahead, way_mm)
    session.send(_C.RVEL, 60)
    session.watch_alive(1.0)
    session.send(_C.STOP)
    session.wait_at_rest(4.0)
    left, right = _turned(_ticks(stopped), _ticks(peer.expect(EncoderPacket, SIP_WITHIN_S, what="encoder packet")))
    if not left < 0 < right:
        raise Violation(f"the ticks go by {left} and {right} in a turn to the left", peer.evidence())
    near(-left / right, 1, WHEELS, unit="", what="ticks of the left wheel beside the right one's in a turn")
    session.send(_C.ENCODER, 0)
    session.leave()


def _require_in_step(session: Session, mark: int, start: Ticks, ahead: Ticks, way_mm: float) -> None:
    """Require of each encoder packet of a straight way the ticks that belong to the way in the SIP before it."""
    seen, begun = session.seen(mark), session.first.start_ns
    followed = [pose.x_mm for pose in poses(seen, session.robot)]
    worst_s = 0.0
    for got, packet in session.peer.since(mark, EncoderPacket):
        before = [i for i, one in enumerate(seen) if one.end_ns <= got.start_ns]
        if not before or seen[before[-1]].speed_mm_s < STEADY_MM_S:
            continue
        here = seen[before[-1]]
        for ticks, whole in zip(_turned(start, _ticks(packet)), ahead, strict=True):
            behind_mm = followed[before[-1]] - ticks / whole * way_mm
            worst_s = max(worst_s, abs(behind_mm) / here.speed_mm_s)
    doubt_s = session.uncertainty_s(begun)
    what = "encoders ahead of the SIP before them, or behind it"
    at_most(worst_s, STEP_S, unit="s", what=what, uncertainty=doubt_s)


LEAST_WAY_MM = 100

WHEELS = 0.2
"""How much the wheels may differ, as a share. A choice: no robot with such wheels drives straight on."""

STEADY_MM_S = 150.0

STEP_S = 0.06
"""Ticks belong to the cycle in which they are sent: less than a cycle, by more than a packet takes. A choice."""


@case("S88", bench_time_s=2.2)
def test_inputs_and_outputs_are_the_same_in_both_packets(peer: Peer) -> None:
    """No source says which bytes and converters of an IO packet are those of a SIP: they have to be among them."""
    session = Session(peer)
    before, offs, behind = session.first.sip.digout, list[int](), list[str]()
    session.send(_C.IOREQUEST, 2)
    peer.expect(IoPacket, SIP_WITHIN_S, what="IO packet")
    try:
        for port, outputs in enumerate((0xA5, 0x5A, 0xC3, 0x3C, 0x96), start=1):
            peer.run(port * PHASE_S)
            mark = peer.mark()
            session.send(_C.DIGOUT, pack_bytes(0xFF, outputs))
            offs.append(_require_same(session, session.send(_C.ADSEL, port), port, outputs))
            behind.append(_old_outputs(session, mark))
    finally:  # something may hang on the outputs of a real robot
        session.send(_C.DIGOUT, pack_bytes(0xFF, before))
        session.send(_C.IOREQUEST, 0)
    session.leave()
    if min(offs) > 0 or max(offs) < 0:
        raise Violation(f"analog inputs: those of IO packets are off by {offs} of 256 from those of SIPs, each time")
    if all(behind):
        raise Violation(f"digital outputs: an IO packet is older than the SIPs around it, each time: {behind[-1]}")


PHASE_S = 0.02
"""By which commands come at other points of a cycle."""


def _old_outputs(session: Session, mark: int) -> str:
    """Return what an IO packet says whose outputs are neither those of the SIP before it nor of the one behind it.

    A command between the making of a packet and of its SIP may make one such packet, and not at each point of a cycle.
    """
    packets = [got.packet for got in session.peer.received[mark:] if isinstance(got.packet, (Sip, IoPacket))]
    for before, io, behind in zip(packets, packets[1:], packets[2:], strict=False):
        if isinstance(io, IoPacket) and isinstance(before, Sip) and isinstance(behind, Sip) and io.digout:
            around = {before.digout, behind.digout}
            if not around & {*io.digout}:
                return f"{io.digout[0]:02X} between {before.digout:02X} and {behind.digout:02X}"
    return ""


def _require_same(session: Session, arrived_ns: int, port: int, outputs: int) -> int:
    """Require what is said twice; return how far off the analog value of the IO packet is, which may be noise."""
    peer = session.peer
    around = [session.next_after(arrived_ns).sip, session.next().sip]
    io = peer.expect(IoPacket, SIP_WITHIN_S, what="IO packet")
    around.append(session.next().sip)
    if port not in divmod(around[-1].timer, 0x100):
        raise Violation(f"the selected port is {around[-1].timer:04X} after ADSEL {port}", peer.evidence())
    if around[-1].digout != outputs:
        raise Violation(f"the outputs are {around[-1].digout:02X} after DIGOUT {outputs:02X}", peer.evidence())
    _require_among("digital outputs", [sip.digout for sip in around], io.digout, peer)
    _require_among("digital inputs", [sip.digin for sip in around], io.digin, peer)
    off = _off([sip.analog for sip in around], [value >> 2 for value in io.analog])
    if abs(off) > NOISE_COUNTS:
        _require_among("analog input", [sip.analog for sip in around], [value >> 2 for value in io.analog], peer)
    return off


NOISE_COUNTS = 2
"""Of 256, by which a converter may differ from one reading to the next. A choice."""


def _off(of_sips: Sequence[int], of_io: Sequence[int]) -> int:
    """Return how far the nearest value of an IO packet is above the SIPs around it, or below; 0 for none."""
    return min((value - min(max(value, min(of_sips)), max(of_sips)) for value in of_io), key=abs, default=0)


def _require_among(what: str, of_sips: Sequence[int], of_io: Sequence[int], peer: Peer) -> None:
    """Require one of the values of an IO packet in the SIPs around it, between which it may have changed."""
    if of_io and _off(of_sips, of_io):
        shown = ", ".join(f"{value:02X}" for value in of_io)
        text = f"{what}: {of_sips[-1]:02X} in SIPs, {shown} in the IO packet between them"
        raise Violation(text, peer.evidence())


INPUTS = (
    (0x35, (0x0A3, 0x15C, 0x2F1, 0x306, 0x0C8)),
    (0xC9, (0x11D, 0x0E2, 0x34A, 0x259, 0x3B7)),
    (0x5A, (0x27E, 0x38F, 0x064, 0x1D1, 0x192)),
)
"""Levels and voltages that are driven, of which no two are alike."""


@case("S93", bench_time_s=1.0)
def test_inputs_are_those_of_the_connector(peer: Peer, bench: VirtualCase) -> None:
    session = Session(peer)
    for port, (levels, voltages) in enumerate(INPUTS, start=2):
        bench.drive_inputs(levels, voltages)
        sip = session.next_after(session.send(_C.ADSEL, port)).sip
        session.send(_C.IOREQUEST, 1)
        io = peer.expect(IoPacket, SIP_WITHIN_S, what="IO packet")
        for packet, found, wanted in (
            ("SIP", (sip.digin, sip.analog), (levels, voltages[port - 1] >> 2)),
            ("IO packet", (io.digin, io.analog), ((levels,), voltages)),
        ):
            assert found == wanted, f"levels and voltages in the {packet} are {found}, required {wanted}"
    session.leave()


@case("S45", bench_time_s=1.6)
def test_sonar_goes_off_and_on(peer: Peer) -> None:
    session = Session(peer)
    for argument in (0, 1):
        session.next_after(session.send(_C.SONAR, argument))
        seen = session.watch(0.6)
        if any(bool(s.sip.flags & 2) != bool(argument) for s in seen):
            raise Violation(f"flag bit 1 does not follow SONAR {argument}", peer.evidence())
        readings = sum(len(s.sip.sonars) for s in seen)
        if bool(readings) != bool(argument):
            raise Violation(f"{readings} sonar readings in 0.6 s after SONAR {argument}", peer.evidence())
    session.leave()


@case("S46", bench_time_s=1.6)
def test_polling_selects_the_discs(peer: Peer) -> None:
    """Looks at the first array only: the others keep their sequences (Pioneer 2/3 H8 manual, POLLING)."""
    session = Session(peer)
    for first, second in ((1, 5), (3, 7)):
        session.next_after(session.send(_C.POLLING, bytes((first, second))))
        seen = session.watch(0.6)
        discs = sorted({reading.number for s in seen for reading in s.sip.sonars if reading.number < 8})
        if discs != [first - 1, second - 1]:
            session.send(_C.POLLING, bytes(range(1, 9)))
            raise Violation(f"the discs {discs} reported after POLLING {first} {second}", peer.evidence())
    session.send(_C.POLLING, bytes(range(1, 9)))
    session.leave()


@case("S47", bench_time_s=0.4)
def test_digital_outputs_are_set(peer: Peer) -> None:
    session = Session(peer)
    before = session.first.sip.digout
    if before == 0x0F:
        session.next_after(session.send(_C.DIGOUT, pack_bytes(0xFF, 0xF0)))
    arrived_ns = session.write(bytes.fromhex("FAFB061E1BF1000F1B"))
    after = [session.next_after(arrived_ns).sip.digout for _ in range(2)][-1]
    session.send(_C.DIGOUT, pack_bytes(0xFF, before))
    assert after == 0x0F, f"the outputs are {after:02X} after DIGOUT with mask FF and value 0F"
    session.leave()


@case("S48", bench_time_s=1.2)
def test_commands_of_other_robots_are_ignored(peer: Peer) -> None:
    """The session is unaffected if the SIPs go on as they were, and the next command is obeyed."""
    session = Session(peer)
    before = session.next().sip
    mark = peer.mark()
    session.send(_C.BATTERYINFO, 1)
    session.send(_C.BATTERYINFO, 0)
    session.send(200)
    session.send(_C.LOADWORLD, b"")
    session.send(_C.STEP)
    seen = session.watch(0.8)
    if len(seen) < 0.6 / CYCLE_S:
        raise Violation("the stream of SIPs has stopped", peer.evidence(mark))
    if any(s.sip.flags != before.flags or not s.at_rest for s in seen):
        raise Violation("flags or motion have changed", peer.evidence(mark))
    session.motors_on()
    session.leave()
