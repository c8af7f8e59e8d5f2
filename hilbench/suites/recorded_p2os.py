"""Recordings of a P2OS line: the clauses of server and client that can be judged by listening alone.

Limits are those of the clauses. What a case of a live run would provoke is looked for here, wherever it happened.
"""

from __future__ import annotations

import contextlib
import statistics
from collections.abc import Iterator
from itertools import pairwise, takewhile

from hilbench.check import NotApplicable, Violation, near
from hilbench.check.capture_provider import CaptureCase
from hilbench.clock import NS_PER_S
from hilbench.recordings.listening import HOST, TARGET, Heard, Stretch
from hilbench.suites._recorded import Worst, around, judge_answers, on_recording, stretches_of
from hilbench.suites._recorded_session import OPENED, Means, Session, Step, sessions_of, steps_of
from hilbench.suites._requirements import SLOPE
from hilbench.suites._session import CYCLE_S
from hilbench.systems.pioneer.peer import REPLY_WITHIN_S
from protocols.p2os import (
    ROBOTS,
    CommandNumber,
    ControllerReset,
    Identification,
    RemoteProtocolError,
    Sip,
    SyncEcho,
    decode_packet,
)
from protocols.p2os.framing import HEADER, MAX_COUNT_STRICT

SYNC0, SYNC1 = bytes.fromhex("FAFB03000000"), bytes.fromhex("FAFB03010001")
FEWEST_SIPS = 5
"""In a row, to judge their rate by (choice)."""
UNASKED_S = 0.5
"""So long after the last byte to a server nothing that it says is an answer (choice: longer than one may take)."""
PULSE_SEEN_S = 0.7
"""So long an answer to PULSE, or the end of the SIPs, is looked for."""
KEEPALIVE_S = 1.0
WATCHDOG_S, BRAKING_MM_S2, STOP_SEEN_S = 2.0, 300, 0.25
CLOSED_WITHIN_S = 0.2
IDENTIFIED = 3
STRING = 0x2B
"""The type of an argument; its length follows, and a NUL behind it is not counted."""


def steps(bench: CaptureCase, end: str) -> Iterator[tuple[Stretch, Step]]:
    return ((stretch, step) for stretch in stretches_of(bench, end) for step in steps_of(stretch))


def sessions(bench: CaptureCase, end: str) -> Iterator[Session]:
    return (session for stretch in stretches_of(bench, end) for session in sessions_of(stretch))


def packet_of(one: Heard) -> object:
    try:
        return decode_packet(one.item.raw[3:-2], connected=False) if one.sound else None
    except RemoteProtocolError:
        return None


# --- the server: the handshake


def clean(bench: CaptureCase, means: Means, answered: int | None) -> Iterator[tuple[Stretch, Heard]]:
    """Yield what was asked by a client that had not said anything for a while that is no sound frame."""
    noise_ns: dict[int, int] = {}
    for stretch, step in steps(bench, TARGET):
        if step.heard.by == HOST and step.means is Means.NOISE:
            noise_ns[id(stretch)] = step.heard.ns
        recent = step.heard.ns - noise_ns.get(id(stretch), -NS_PER_S) < NS_PER_S
        if step.means is means and not recent and answered in {None, step.answered}:
            yield stretch, step.heard


@on_recording("S01")
def test_sync0_is_echoed(bench: CaptureCase) -> None:
    judge_echoes(clean(bench, Means.SYNC0, None), SYNC0, "echo of SYNC0", "nobody sent SYNC0 before a session")


@on_recording("S02")
def test_sync1_is_echoed(bench: CaptureCase) -> None:
    never = "nobody sent SYNC1 behind an answered SYNC0"
    judge_echoes(clean(bench, Means.SYNC1, 1), SYNC1, "echo of SYNC1", never)


def judge_echoes(asked: Iterator[tuple[Stretch, Heard]], sync: bytes, what: str, never: str) -> None:
    """Require the same six bytes; another echo of the same number is an answer, and a wrong one."""

    def echoes(one: Heard) -> bool:
        packet = packet_of(one)
        return one.item.raw == sync or (isinstance(packet, SyncEcho) and packet.number == sync[3])

    judge_answers(asked, REPLY_WITHIN_S, echoes, TARGET, right=lambda one: one.item.raw == sync, what=what, never=never)


@on_recording("S03")
def test_sync2_is_answered_with_the_identification(bench: CaptureCase) -> None:
    for stretch in stretches_of(bench, TARGET):
        for one in stretch.by(TARGET):
            packet = packet_of(one)
            if isinstance(packet, Identification):
                require_identification(packet, one, stretch)
    judge_answers(
        clean(bench, Means.SYNC2, 2),
        REPLY_WITHIN_S,
        lambda one: isinstance(packet_of(one), Identification),
        TARGET,
        what="identification",
        never="nobody sent SYNC2 behind an answered SYNC1",
    )


def require_identification(packet: Identification, one: Heard, stretch: Stretch) -> None:
    strings, where = one.item.raw[4:-2].split(b"\0"), stretch.at(one.ns)
    if len(strings) != 4 or strings[3]:
        raise Violation(f"not three strings that each end with a NUL ({where})", around(stretch, one.ns))
    if packet.robot_class != "Pioneer" or packet.subclass.lower() not in ROBOTS:
        what = f"class {packet.robot_class!r} and subclass {packet.subclass!r}, which no client knows"
        raise Violation(f"{what} ({where})", around(stretch, one.ns))


@on_recording("S04")
def test_nothing_is_sent_unasked(bench: CaptureCase) -> None:
    """Up to OPEN of the first session; what comes after one is the business of S40.

    Where it is not known what was said before, an answer to that may come first.
    """
    listened = False
    for stretch in stretches_of(bench, TARGET):
        asked_ns, due = stretch.begin_ns, 0
        for step in steps_of(stretch):
            in_session = step.answered == OPENED or (isinstance(step.packet, Sip) and not step.answered)
            if step.means is Means.OPEN or in_session:
                break
            waited = step.heard.ns - asked_ns > UNASKED_S * NS_PER_S
            listened |= waited
            if step.heard.by == HOST:
                asked_ns, due = step.heard.ns, due + 1
                continue
            early = not stretch.from_start and step.heard.ns - stretch.begin_ns <= UNASKED_S * NS_PER_S
            if early and step.heard.sound:
                continue
            due -= 1
            if (waited or due < 0) and stretch.quiet(asked_ns, step.heard.ns):
                raise Violation(f"nobody has asked ({stretch.at(step.heard.ns)})", around(stretch, step.heard.ns))
        else:
            listened |= stretch.end_ns - asked_ns > UNASKED_S * NS_PER_S
    if not listened:
        raise NotApplicable(f"nobody was silent for {UNASKED_S:g} s before a session in this recording")


def opened(bench: CaptureCase, bare: bool) -> Iterator[tuple[Stretch, Heard]]:
    for stretch, step in steps(bench, TARGET):
        command = step.command
        identified = step.means is Means.OPEN and step.answered == IDENTIFIED
        if identified and command is not None and (command.argument is None) is bare:
            yield stretch, step.heard


def is_sip(one: Heard) -> bool:
    return isinstance(packet_of(one), Sip)


@on_recording("S05")
def test_open_without_argument_starts_sips(bench: CaptureCase) -> None:
    judge_answers(
        opened(bench, True),
        REPLY_WITHIN_S,
        is_sip,
        TARGET,
        what="first SIP after OPEN",
        to_its_start=True,
        never="nobody sent OPEN without an argument",
    )


@on_recording("S06")
def test_open_with_argument_starts_sips(bench: CaptureCase) -> None:
    judge_answers(
        opened(bench, False),
        REPLY_WITHIN_S,
        is_sip,
        TARGET,
        what="first SIP after OPEN 1",
        to_its_start=True,
        never="nobody sent OPEN with an argument",
    )


# --- the server: in session


def undisturbed(session: Session) -> Iterator[list[tuple[Step, Sip]]]:
    """Yield the SIPs in a row; not the one behind another packet or a disturbance, which may have been held up."""
    row: list[tuple[Step, Sip]] = []
    last_ns, held_up = 0, False
    for step in session.steps:
        if step.heard.by != TARGET:
            continue
        if not isinstance(step.packet, Sip) or (last_ns and not session.stretch.quiet(last_ns, step.heard.ns)):
            yield row
            row, held_up = [], True
        elif held_up:
            held_up = False
        else:
            row.append((step, step.packet))
        last_ns = step.heard.ns
    yield row


@on_recording("S18")
def test_sips_come_at_their_rate(bench: CaptureCase) -> None:
    worst: tuple[float, float, float, str] | None = None
    doubt_s = 0.0
    for session in sessions(bench, TARGET):
        require_sound(session)
        require_flow(session)
        for row in undisturbed(session):
            spans_s = [(b.start_ns - a.start_ns) / NS_PER_S for (a, _), (b, _) in pairwise(row)]
            if len(row) < FEWEST_SIPS:
                continue
            cycle_s = CYCLE_S if statistics.median(spans_s) > 0.75 * CYCLE_S else CYCLE_S / 2
            at = max(range(len(spans_s)), key=lambda number: abs(spans_s[number] - cycle_s))
            where = session.stretch.at(row[at + 1][0].heard.ns)
            found = (abs(spans_s[at] - cycle_s), spans_s[at], cycle_s, where)
            worst = max(worst or found, found)
            doubt_s = session.stretch.uncertainty_s
    if worst is None:
        raise NotApplicable(f"there are no {FEWEST_SIPS} SIPs in a row in this recording")
    _, span_s, cycle_s, where = worst
    what = f"interval of SIPs farthest off ({where})"
    near(span_s * 1000, cycle_s * 1000, 10, unit="ms", what=what, uncertainty=doubt_s * 1000)


def require_sound(session: Session) -> None:
    """Require packets, and SIPs of the length and the type that they must have; up to a change of the rate."""
    for step in session.steps:
        if step.command is not None and step.command.number == CommandNumber.HOSTBAUD:
            return
        if step.heard.by != TARGET or not session.stretch.quiet(session.steps[0].heard.ns, step.heard.ns):
            continue
        raw, packet, where = step.heard.item.raw, step.packet, session.stretch.at(step.heard.ns)
        if not step.heard.sound:
            raise Violation(f"bytes came that are no sound packet ({where})", around(session.stretch, step.heard.ns))
        if not isinstance(packet, Sip):
            continue
        if raw[2] != 27 + 3 * raw[22]:
            raise Violation(f"count {raw[2]} with {raw[22]} sonar readings, not {27 + 3 * raw[22]} ({where})")
        if packet.moving and not (packet.motors_enabled or packet.left_raw or packet.right_raw):
            raise Violation(f"type {raw[3]:02X} of a robot that stands, its motors off ({where})")


def require_flow(session: Session) -> None:
    """Require SIPs up to CLOSE: without one, none may be missing for a whole second."""
    last = session.steps[-1]
    sip_ns = session.sips()[-1][0].heard.ns
    ended = last.means is Means.CLOSE or isinstance(last.packet, ControllerReset)
    if not ended and session.stretch.quiet(session.steps[0].heard.ns, sip_ns + NS_PER_S):
        where = session.stretch.at(sip_ns)
        raise Violation(f"the SIPs stopped without a CLOSE ({where})", around(session.stretch, sip_ns))


@on_recording("S36")
def test_silence_stops_the_robot(bench: CaptureCase) -> None:
    """Only of a robot that drove straight on; what it brakes with is what SETA has said in this session."""
    worst = Worst("at rest after the last command, beyond what its speed allows", "s")
    for session in filter(lambda one: one.seen_opened, sessions(bench, TARGET)):
        for begin_ns, braking_mm_s2, row in silences(session):
            judge_stop(session, begin_ns, braking_mm_s2, row, worst)
    worst.judge(0.0, f"nobody was silent for more than {WATCHDOG_S:g} s while the robot drove")


def silences(session: Session) -> Iterator[tuple[int, int, list[tuple[Step, Sip]]]]:
    """Yield when the last command before a silence came, what the robot brakes with then, and the SIPs in it."""
    begin_ns, braking_mm_s2, row = session.steps[0].heard.ns, BRAKING_MM_S2, list[tuple[Step, Sip]]()
    for step in session.steps:
        if step.heard.by == HOST:
            yield begin_ns, braking_mm_s2, row
            begin_ns, braking_mm_s2, row = step.heard.ns, braking_set(step) or braking_mm_s2, []
        elif isinstance(step.packet, Sip):
            row.append((step, step.packet))
    yield begin_ns, braking_mm_s2, row


def braking_set(step: Step) -> int:
    """Return what a command sets for braking, in mm/s2; 0 if it sets nothing."""
    if step.command is None or step.command.number != CommandNumber.SETA:
        return 0
    return max(0, -step.command.argument) if isinstance(step.command.argument, int) else 0


def judge_stop(session: Session, begin_ns: int, braking_mm_s2: int, row: list[tuple[Step, Sip]], worst: Worst) -> None:
    fastest = max((max(abs(sip.left_raw), abs(sip.right_raw)) for _, sip in row), default=0)
    turns = any(abs(sip.left_raw - sip.right_raw) > 20 for _, sip in row)
    allowed_s = WATCHDOG_S + fastest / (braking_mm_s2 * (1 - SLOPE)) + STOP_SEEN_S
    listened_s = (row[-1][0].heard.ns - begin_ns) / NS_PER_S if row else 0.0
    if not fastest or turns or listened_s < allowed_s or not session.stretch.quiet(begin_ns, row[-1][0].heard.ns):
        return
    at_ns = [step.start_ns for step, _ in row]
    longest_s = max((after - before) / NS_PER_S for before, after in pairwise(at_ns))
    if longest_s > 1.5 * CYCLE_S + session.stretch.uncertainty_s:
        raise Violation(f"a pause of {longest_s:.3f} s between SIPs ({session.stretch.at(begin_ns)})")
    moving = [step for step, sip in row if sip.moving or sip.left_raw or sip.right_raw]
    if moving[-1] is row[-1][0]:
        where = session.stretch.at(begin_ns)
        raise Violation(f"the robot still moves {listened_s:.2f} s after the last command ({where})")
    at_rest = next(step for step, _ in row if step.start_ns > moving[-1].start_ns)
    took_s = (at_rest.start_ns - begin_ns) / NS_PER_S
    worst.take(took_s - allowed_s, session.stretch.at(begin_ns), session.stretch.uncertainty_s)


def behind(steps: list[Step], at: int, within_s: float) -> list[Step]:
    """Return what comes behind a step within a time."""
    until_ns = steps[at].heard.ns + round(within_s * NS_PER_S)
    following = (steps[number] for number in range(at + 1, len(steps)))
    return list(takewhile(lambda one: one.heard.ns <= until_ns, following))


@on_recording("S39")
def test_pulse_has_no_answer(bench: CaptureCase) -> None:
    pulses = 0
    for session in sessions(bench, TARGET):
        for at, step in enumerate(session.steps):
            if step.means is Means.PULSE:
                pulses += 1
                require_no_echo(session, step, behind(session.steps, at, PULSE_SEEN_S))
    if not pulses:
        raise NotApplicable("no session in this recording has a PULSE")


def require_no_echo(session: Session, pulse: Step, following: list[Step]) -> None:
    """Look at what comes up to the next command."""
    stretch, begin_ns = session.stretch, pulse.heard.ns
    until_ns = min(stretch.end_ns, begin_ns + round(PULSE_SEEN_S * NS_PER_S))
    until_ns = next((step.heard.ns for step in following if step.heard.by == HOST), until_ns)
    within_it = [step for step in following if step.heard.ns <= until_ns]
    if any(isinstance(step.packet, SyncEcho) for step in within_it):
        raise Violation(f"PULSE was echoed like a SYNC0 ({stretch.at(begin_ns)})", around(stretch, begin_ns))
    listened_s = (until_ns - begin_ns) / NS_PER_S
    sips = sum(isinstance(step.packet, Sip) for step in within_it)
    if listened_s >= PULSE_SEEN_S and sips < 0.5 / CYCLE_S and stretch.quiet(begin_ns, until_ns):
        raise Violation(f"PULSE has ended the stream of SIPs ({stretch.at(begin_ns)})", around(stretch, begin_ns))


@on_recording("S40")
def test_close_ends_the_session(bench: CaptureCase) -> None:
    """Listens for half a second, as long as nobody says anything more."""
    worst = Worst("last SIP after CLOSE", "s")
    for stretch in stretches_of(bench, TARGET):
        found = list(steps_of(stretch))
        for at, step in enumerate(found):
            if step.means is not Means.CLOSE:
                continue
            following = behind(found, at, UNASKED_S)
            listened = stretch.quiet(step.heard.ns, step.heard.ns + round(UNASKED_S * NS_PER_S))
            if listened and not any(one.heard.by == HOST for one in following):
                last = max((one.heard.ns for one in following if isinstance(one.packet, Sip)), default=step.heard.ns)
                worst.take((last - step.heard.ns) / NS_PER_S, stretch.at(step.heard.ns), stretch.uncertainty_s)
    worst.judge(CLOSED_WITHIN_S, "nobody listened for half a second behind a CLOSE")
    again = ((stretch, step.heard) for stretch, step in steps(bench, TARGET)
             if step.means is Means.SYNC0 and step.sessions and not step.answered)  # fmt: skip
    with contextlib.suppress(NotApplicable):
        judge_echoes(again, SYNC0, "echo of SYNC0 behind a session", "none")


# --- the client


@on_recording("C02")
def test_the_handshake_goes_step_by_step(bench: CaptureCase) -> None:
    order = (Means.SYNC0, Means.SYNC1, Means.SYNC2, Means.OPEN)
    seen = 0
    for stretch in stretches_of(bench, HOST):
        asked: Means | None = None
        followed = stretch.from_start
        for step in steps_of(stretch):
            followed |= step.means is Means.SYNC0
            if step.heard.by == TARGET:
                asked = None
            elif followed and step.means in order:
                seen += step.means is not Means.SYNC0
                early = asked is not None and order.index(step.means) == order.index(asked) + 1
                if early or (step.means is Means.OPEN and step.answered < IDENTIFIED):
                    what = f"{step.means.value} was sent before the SYNC before it was answered"
                    raise Violation(f"{what} ({stretch.at(step.heard.ns)})", around(stretch, step.heard.ns))
                asked = step.means
    if not seen:
        raise NotApplicable("nobody went further than SYNC0 in this recording")


@on_recording("C22")
def test_the_session_is_kept_alive(bench: CaptureCase) -> None:
    """From the first SIP to the last: what comes behind it is no session any more."""
    worst = Worst("longest silence of the client", "s")
    for session in sessions(bench, HOST):
        sips = session.sips()
        begin_ns, end_ns = sips[0][0].heard.ns, sips[-1][0].heard.ns
        said = [step.heard.ns for step in session.steps if step.heard.by == HOST and step.heard.ns < end_ns]
        if end_ns - begin_ns < KEEPALIVE_S * NS_PER_S:
            continue
        for before, after in pairwise([begin_ns, *said, end_ns]):
            where = session.stretch.at(before)
            worst.take((after - before) / NS_PER_S, where, session.stretch.uncertainty_s)
    worst.judge(KEEPALIVE_S, f"no session lasted for {KEEPALIVE_S:g} s")


@on_recording("C25")
def test_packets_keep_to_their_limits(bench: CaptureCase) -> None:
    worst = Worst("largest count", "")
    for stretch in stretches_of(bench, HOST):
        for one in stretch.by(HOST):
            raw = one.item.raw
            if raw.startswith(HEADER) and len(raw) > len(HEADER):
                worst.take(raw[2], stretch.at(one.ns), 0.0)
            if one.sound and raw[4] == STRING and raw[5] not in {len(raw) - 8, len(raw) - 9}:
                what = f"a length byte of {raw[5]} before {len(raw) - 8} bytes"
                raise Violation(f"{what} ({stretch.at(one.ns)})", around(stretch, one.ns))
    worst.judge(MAX_COUNT_STRICT, "a client sent no packet")
