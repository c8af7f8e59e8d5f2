"""What a run shows beside its verdicts: how much of the peer was exercised, how exact the bench was.

A provider that can tell has a method ``observed``; the engine asks it once, when the last case is over.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import msgspec


class Coverage(msgspec.Struct, frozen=True, kw_only=True):
    """How much of a peer's state machine the run went through; of virtual peers only, nobody sees into others.

    Attributes:
        peer: ``server`` or ``client``.
        states: how many states the machine has.
        states_missed: those that were never entered.
        edges: how many edges it has: pairs of a state and what happens there.
        edges_missed: those that were never taken, as ``STATE TRIGGER``.
    """

    peer: str
    states: int
    states_missed: tuple[str, ...]
    edges: int
    edges_missed: tuple[str, ...]


class TouchedFeature(msgspec.Struct, frozen=True, kw_only=True):
    """A feature that is not wholly modelled, and that a command of the run was about.

    Attributes:
        feature: what it is.
        fidelity: ``partly`` or ``absent``.
        note: what to know before trusting it.
        commands: the commands that touched it.
        case_ids: the cases in which they came.
    """

    feature: str
    fidelity: str
    note: str
    commands: tuple[str, ...]
    case_ids: tuple[str, ...]


class IgnoredCommand(msgspec.Struct, frozen=True, kw_only=True):
    """A command that had no effect, as on the real robot.

    Attributes:
        command: its name.
        reason: why it had none.
        case_ids: the cases in which it came.
    """

    command: str
    reason: str
    case_ids: tuple[str, ...]


class Ledger(msgspec.Struct, frozen=True, kw_only=True):
    """How far the virtual target is modelled, and what of it the run touched.

    Attributes:
        modelled: how many features are modelled.
        partly: how many are partly modelled.
        absent: how many are absent.
        touched: the features not wholly modelled that a command was about.
        ignored: the commands that had no effect.
    """

    modelled: int
    partly: int
    absent: int
    touched: tuple[TouchedFeature, ...] = ()
    ignored: tuple[IgnoredCommand, ...] = ()


class EmulationNote(msgspec.Struct, frozen=True, kw_only=True):
    """Something about the firmware of an emulated board that a reader of its verdicts should know.

    Attributes:
        board: the board, by its name in the bench.
        kind: ``unmodelled`` (it touched what the model lacks), ``clock-off``, ``misuse`` (silicon would not do what was
            meant), ``reserved`` (no such register), ``assumed`` (the model chose what the manual leaves open),
            ``image``, ``reset`` (not by button or power), ``fault``, or how it came to its end, such as ``lockup``.
        where: register and bits, or what else it is about.
        text: what was done and what comes of it.
        at: the place in the program, the first time; empty where there is none.
        case_ids: the cases in which it was seen.
    """

    board: str
    kind: str
    where: str
    text: str
    at: str
    case_ids: tuple[str, ...]


class Pace(msgspec.Struct, frozen=True, kw_only=True):
    """How well the host kept up with bench time, on a bench in real time.

    Attributes:
        lateness_p50_s: lateness that half of all wake-ups did not exceed, in seconds.
        lateness_p99_s: lateness that 99 % of them did not exceed, in seconds.
        lateness_max_s: the greatest, in seconds.
        slips: how often bench time stood still because the host was too late to catch up.
        slipped_s: how long it stood still in all, in seconds.
        real_time_factor: bench seconds per second of the host.
    """

    lateness_p50_s: float
    lateness_p99_s: float
    lateness_max_s: float
    slips: int
    slipped_s: float
    real_time_factor: float


class PortCounters(msgspec.Struct, frozen=True, kw_only=True):
    """What passed the bench's end of the line, over all the times it was opened.

    Attributes:
        sent: bytes handed to the line.
        received: bytes that came off the line.
        lost: bytes handed over that could not be delivered.
        overruns: bytes refused because the transmit queue was full.
        framing_errors: bytes received without a stop bit where one was due.
        parity_errors: bytes received with the wrong parity, where the driver of a real port counts them.
        receive_overruns: bytes that a real port's UART or driver had no room for, as above.
        breaks: break conditions received.
        breaks_unsent: breaks asked for that this port cannot send.
        refused: clients refused.
        withdrawn: bytes handed over and taken back before they were sent.
    """

    sent: int = 0
    received: int = 0
    lost: int = 0
    overruns: int = 0
    framing_errors: int = 0
    parity_errors: int = 0
    receive_overruns: int = 0
    breaks: int = 0
    breaks_unsent: int = 0
    refused: int = 0
    withdrawn: int = 0


class Observations(msgspec.Struct, frozen=True, kw_only=True):
    """What a run shows beside its verdicts; nothing of it enters the run hash.

    Attributes:
        coverage: of the state machines of the virtual peers that were tested.
        ledger: fidelity of the virtual target; null if none was built.
        pace: how well the host kept up; null on a bench in virtual time.
        port: counters of the port; null on a bench without one.
        notes: on the firmware of emulated boards, each once.
    """

    coverage: tuple[Coverage, ...] = ()
    ledger: Ledger | None = None
    pace: Pace | None = None
    port: PortCounters | None = None
    notes: tuple[EmulationNote, ...] = ()


@runtime_checkable
class Observing(Protocol):
    """A provider that can tell what its benches showed."""

    def observed(self) -> Observations:
        """Return what was seen so far, over all cases."""
