"""What is sent or set on request, and commands of other robots."""

from __future__ import annotations

from hilbench.check import Violation, case
from hilbench.suites._requirements import require_request
from hilbench.suites._session import CYCLE_S, Session
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber, ConfigPacket, EncoderPacket, IoPacket, pack_bytes

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


@case("S46", bench_time_s=1.3)
def test_polling_selects_the_discs(peer: Peer) -> None:
    """Looks at the first array only: the others keep their sequences (Pioneer 2/3 H8 manual, POLLING)."""
    session = Session(peer)
    session.next_after(session.send(_C.POLLING, bytes((1, 5))))
    seen = session.watch(1.0)
    discs = sorted({reading.number for s in seen for reading in s.sip.sonars if reading.number < 8})
    session.send(_C.POLLING, bytes(range(1, 9)))
    assert discs == [0, 4], f"the discs {discs} reported after POLLING 1 5, not 0 and 4"
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
