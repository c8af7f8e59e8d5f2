"""What a connection counts; each dropped frame has the counter of its reason."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.carla.reading import DropReason

__all__ = ["COUNTER_OF_DROP", "Counters"]


@dataclass(slots=True, kw_only=True)
class Counters:
    """What a connection has seen and done, since it was made.

    Attributes:
        bytes_in: bytes received.
        bytes_out: bytes sent.
        frames_in: frames that were believed.
        frames_out: frames sent.
        ignored: triggers that a state has no edge for.
        noise: runs of bytes in which no frame begins.
        bad_letters: frames with another byte where a letter should stand.
        missing_fields: frames that lack a field.
        duplicate_fields: frames with a field twice.
        timed_out: unfinished frames given up.
        not_finite: frames with a NaN or an infinity.
        implausible: frames with values beyond what can be true.
        unknown_modes: commands with a mode that nobody knows.
        empty_blocks: board: blocks of 22 bytes in which no frame ended.
        overruns: simulator: reads before which bytes had found the buffer full.
        line_errors: overrun and framing errors.
        lost_bytes: board: bytes that came after reception had ended.
        commands: board: commands taken from the driving stack.
        commands_refused: board: commands of the driving stack with impossible values.
        commands_unused: board: commands of the driving stack outside AUTOWARE, or from an agent that is not heard.
        command_misses: board: deadlines without a command.
        status_misses: board: deadlines without a status.
        mode_changes: board: changes of mode.
        emergencies: board: changes to EMERGENCY.
        requests: board: mode requests that were answered.
        requests_refused: board: those answered with no.
        flags_eaten: board: flags for the micro-ROS task that the control task took for a status.
        presses: board: presses that were seen.
        presses_ignored: board: presses that did nothing.
        status_reports: board: statuses reported to the driving stack.
        stale_reports: board: those of them that were old.
        stale_dropped: board: statuses that had waited for too long to be an answer.
        sent_again: board: frames sent again.
        stops_sent: board: frames sent to stop the car while commands are missing.
        uninitialised: board: frames sent that nobody had filled.
        agent_losses: board: times that the driving stack was lost.
        published: simulator: commands handed on to the car.
        clamped: simulator: those with a value set back into its range.
        silences: simulator: times that the board was silent for too long.
        polls: simulator: reads that yielded bytes.
        blocks: simulator: reads that found nothing and waited.
        read_errors: simulator: reads that failed.
        sends_delayed: simulator: statuses that had to wait for a read.
    """

    bytes_in: int = 0
    bytes_out: int = 0
    frames_in: int = 0
    frames_out: int = 0
    ignored: int = 0
    noise: int = 0
    bad_letters: int = 0
    missing_fields: int = 0
    duplicate_fields: int = 0
    timed_out: int = 0
    not_finite: int = 0
    implausible: int = 0
    unknown_modes: int = 0
    empty_blocks: int = 0
    overruns: int = 0
    line_errors: int = 0
    lost_bytes: int = 0
    commands: int = 0
    commands_refused: int = 0
    commands_unused: int = 0
    command_misses: int = 0
    status_misses: int = 0
    mode_changes: int = 0
    emergencies: int = 0
    requests: int = 0
    requests_refused: int = 0
    flags_eaten: int = 0
    presses: int = 0
    presses_ignored: int = 0
    status_reports: int = 0
    stale_reports: int = 0
    stale_dropped: int = 0
    sent_again: int = 0
    stops_sent: int = 0
    uninitialised: int = 0
    agent_losses: int = 0
    published: int = 0
    clamped: int = 0
    silences: int = 0
    polls: int = 0
    blocks: int = 0
    read_errors: int = 0
    sends_delayed: int = 0

    def drop(self, reason: DropReason) -> None:
        """Counts bytes that did not become a message."""
        name = COUNTER_OF_DROP[reason]
        setattr(self, name, getattr(self, name) + 1)


COUNTER_OF_DROP = {
    DropReason.NOISE: "noise",
    DropReason.BAD_LETTER: "bad_letters",
    DropReason.MISSING_FIELD: "missing_fields",
    DropReason.DUPLICATE_FIELD: "duplicate_fields",
    DropReason.TIMED_OUT: "timed_out",
    DropReason.NOT_FINITE: "not_finite",
    DropReason.IMPLAUSIBLE: "implausible",
    DropReason.UNKNOWN_MODE: "unknown_modes",
    DropReason.EMPTY_BLOCK: "empty_blocks",
    DropReason.OVERRUN: "overruns",
}
"""The counter of each reason."""
