"""`hilbench replay --into`: what a host said in a recording, said once more to a target, at the same times.

A virtual target is a fresh one for each case, in virtual time; a real one gets the bytes in real time. What it answers
is held against what the recording has, frame by frame: another answer is a difference, another time is none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

from hilbench.bench.line_peer import LinePeer
from hilbench.bench.protocol_peer import peer_of
from hilbench.clock import NS_PER_S
from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Journal, Recording
from hilbench.judging.provider import PLAIN_SETUP, BenchProvider, CaseBench, CaseInfo, CaseSetup, case_seed
from hilbench.mcu.board_case import BoardCase
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.recordings.listening import HOST, TARGET, Talk, talks
from protocols.common.item_words import said
from protocols.common.items import Item

__all__ = ["SETTLE_S", "Replayed", "replay_into"]

SETTLE_S = 0.5
"""How long the last answer may take, beyond the end of the recording (choice)."""
STALLED_S = 1.0
"""How long a line may take nothing before it counts as one that takes nothing more (choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Replayed:
    """One case, or a recording without cases.

    Attributes:
        case: its id; empty without.
        sent: bytes that the host said.
        recorded: frames of the target in the recording.
        answered: frames of the target now.
        number: the first frame that is another one, from 1; 0 if none is.
        before: what it said in the recording; empty if it said nothing more.
        now: what it says now; empty if nothing more.
    """

    case: str
    sent: int
    recorded: int
    answered: int
    number: int = 0
    before: str = ""
    now: str = ""

    @property
    def equal(self) -> bool:
        """Whether the target has answered as in the recording."""
        return not self.number


def replay_into(
    recording: Recording, provider: BenchProvider, protocol: ProtocolPlugin, where: str
) -> Iterator[Replayed]:
    """Say once more what the host said; yield how each case went.

    Args:
        recording: what was recorded.
        provider: opens the target.
        protocol: what is spoken.
        where: the name of the recording, for messages.

    Raises:
        UsageError: no host says anything in it; the bench has no end of a line to play on.
        UnavailableError: the target is not there, or no longer.
    """
    spoken = [talk for talk in talks(recording) if talk.of(HOST)]
    if not spoken:
        raise UsageError("has no bytes sent by a host", where=where)
    seed = recording.header.get("seed", 0)
    for talk in spoken:
        answers = _said_to(provider, talk, seed if isinstance(seed, int) else 0, protocol)
        yield _held_against(talk, answers, protocol)


def _said_to(provider: BenchProvider, talk: Talk, seed: int, protocol: ProtocolPlugin) -> bytes:
    """Open the target, say it, and return what was answered."""
    name = talk.case or "replay"
    answers = bytearray()
    case = CaseInfo(id=name, clause_ids=(), seed=case_seed(seed, name), setup=_setup(name, provider.capabilities))
    with provider.open_case(case) as opened:
        peer = _host_end(opened, case.setup.program, protocol)
        bench = peer.bench
        # What the target says before anything is said to it is an answer of its own, and recorded, too.
        journal: Journal = bench.journal
        heard = journal.on_event
        journal.on_event = lambda event: _take(event, answers)
        begin_ns = bench.now_ns
        try:
            for ns, by, data in talk.said:
                if by == HOST:
                    _wait_until(peer, begin_ns + ns - talk.begin_ns)
                    peer.write(data)
                    journal.flush_step()
            _wait_until(peer, begin_ns + talk.end_ns - talk.begin_ns)
            _let_out(peer)
            _hear_out(peer, answers, len(talk.of(TARGET)))
            peer.require_line()
            opened.finish("not-judged", "replayed")
        finally:
            journal.on_event = heard
    return bytes(answers)


def _wait_until(peer: LinePeer[Any], ns: int) -> None:
    """Let time pass up to then; none if that is over, as where chunks of a recording overlap."""
    peer.bench.scheduler.run_until(lambda: False, max(ns, peer.bench.now_ns))


def _let_out(peer: LinePeer[Any]) -> None:
    """Wait until all that was said is out: the line may be slower than that of the recording.

    Raises:
        UnavailableError: the line takes nothing more.
    """
    scheduler = peer.bench.scheduler
    while waiting := peer.port.pending:
        scheduler.run_until(lambda: not peer.port.pending, scheduler.now_ns + round(STALLED_S * NS_PER_S))
        peer.require_line()
        if peer.port.pending >= waiting:
            wrong = f"takes nothing more: {waiting} bytes that the host said are not out"
            raise UnavailableError(wrong, where=peer.port.name, hint="is the other end ready to receive?")


def _hear_out(peer: LinePeer[Any], answers: bytearray, expected: int) -> None:
    """Wait for the last answer, and on while the answers, fewer than in the recording, are still coming."""
    settle_ns = round(SETTLE_S * NS_PER_S)
    heard = -1
    while heard < 0 or heard < len(answers) < expected:
        heard = len(answers)
        _wait_until(peer, peer.bench.now_ns + settle_ns)


def _setup(case: str, capabilities: frozenset[str]) -> CaseSetup:
    """Return the program that a case is named for, as in ``[g2]``, if the target has it."""
    program = case.rpartition("[")[2].removesuffix("]")
    return CaseSetup(program=program) if f"program '{program}'" in capabilities else PLAIN_SETUP


def _host_end(opened: CaseBench, program: str, protocol: ProtocolPlugin) -> LinePeer[Any]:
    """Return the end of the line that a host has; of emulated boards the one that their bench file leaves to us."""
    if isinstance(opened, BoardCase):
        end = opened.emulated.bench_file.checker_lines.get("")
        if end is not None:
            return peer_of(opened.bench, opened.emulated.far_ends[end], protocol, program)
    elif isinstance(peer := getattr(opened, "peer", None), LinePeer):
        return peer
    raise UsageError("has no line, or several, where one host could be", where="--into")


def _take(event: object, answers: bytearray) -> None:
    if isinstance(event, dict) and event["source"] == "checker" and event["kind"] in {"rx", "dropped"}:
        answers += bytes.fromhex(event["data"])


def _held_against(talk: Talk, answers: bytes, protocol: ProtocolPlugin) -> Replayed:
    before, now = _items(talk.of(TARGET), protocol), _items(answers, protocol)
    ended = len(before)  # what comes behind the end of the recording is no difference
    for number, (one, two) in enumerate(zip_longest(before, now[:ended]), 1):
        if one is None or two is None or one.raw != two.raw:
            return Replayed(
                case=talk.case,
                sent=len(talk.of(HOST)),
                recorded=len(before),
                answered=len(now),
                number=number,
                before="" if one is None else said(one),
                now="" if two is None else said(two),
            )
    return Replayed(case=talk.case, sent=len(talk.of(HOST)), recorded=len(before), answered=len(now))


def _items(data: bytes, protocol: ProtocolPlugin) -> Sequence[Item]:
    decoder = protocol.decoder(protocol.options(), TARGET)
    return [*decoder.feed(data), *decoder.finish()]
