"""What a recording shows of its world at one moment: what stands there, where the vehicle is and where it has been."""

from __future__ import annotations

from dataclasses import dataclass, field

from hilbench.errors import HilbenchError, UnavailableError, UsageError
from hilbench.journal import Recording
from hilbench.recordings.layout import Event, laid_out
from worlds.errors import WorldError
from worlds.stage import FARTHEST_M, Stage
from worlds.world import Pose

__all__ = ["Moment", "moment_of", "pose_of"]

_MILLIONTH = 1e-6
_NO_WORLD = "--case ID takes another case; pcapng, older journals and benches without a world say nothing of it"


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """See the module.

    Attributes:
        ns: when the pose was recorded, in the time of the file (`hilbench.recordings.layout.laid_out`).
        case: the case that runs; empty if there are none.
        stage: what stands there.
        pose: where the vehicle is. A journal has no pitch and no roll, so it is drawn level.
        track: where it was, to that pose, metres; its start first.
    """

    ns: int
    case: str
    stage: Stage
    pose: Pose
    track: tuple[tuple[float, float], ...]


def moment_of(recording: Recording, at_ns: int | None, where: str) -> Moment:
    """Return the last moment that is known at a time.

    Args:
        recording: the whole of it, or one case.
        at_ns: the time in it; None for the last that is known of any case.
        where: its name, for messages.

    Raises:
        UsageError: it ends before, or nothing stands in a world then.
        UnavailableError: it is damaged before, or what it says of its world is.
    """
    last_ns, search = 0, _Search(recording, of_any_case=at_ns is None)
    for last_ns, event in laid_out(recording.events):
        if at_ns is not None and last_ns > at_ns:
            break
        search.take(last_ns, event)
    case, known = search.case, search.known
    if at_ns is not None and last_ns < at_ns:
        raise _not_there(recording, f"ends at {last_ns / 1e9:.3f} s", where)
    if known is None or not (known.starts or known.poses):
        when = "" if at_ns is None else f" at {at_ns / 1e9:g} s" + (f", in case {case}" if case else "")
        raise _not_there(recording, f"says of no vehicle where it stands{when}", where)
    try:
        return _moment(known)
    except WorldError as error:
        raise UnavailableError(str(error), where=where) from error


@dataclass(slots=True)
class _Known:
    """A world of a recording: its case, when it was there, what stands there, and where the vehicle was."""

    case: str
    ns: int
    scene: Event
    starts: bool
    poses: list[tuple[int, Event]] = field(default_factory=list)


class _Search:
    """Finds the last world in the events of a recording.

    Args:
        recording: whose events they are.
        of_any_case: whether a world outlives its case where the next one has none.

    Attributes:
        case: the case that runs.
        known: the world; None if there is none.
    """

    def __init__(self, recording: Recording, *, of_any_case: bool) -> None:
        self.case = ""
        self.known: _Known | None = None
        self._recording = recording
        self._of_any_case = of_any_case
        self._between = True  # cases
        self._ahead = False  # the world was made then, for the next case

    def take(self, ns: int, event: Event) -> None:
        """Take the next event."""
        match event["kind"]:
            case "case":
                self._begin(str(event["case"]))
            case "case-end":
                self._between = True
                self._forget()
            case "scene":
                # What a later part of a journal says anew is not where the vehicle starts.
                starts = not self._recording.header.get("part") or event is not self._recording.events[0]
                self.known, self._ahead = _Known(self.case, ns, event, starts), self._between
            case "pose" if self.known is not None:
                self.known.poses.append((ns, event))

    def _begin(self, case: str) -> None:
        self.case = case
        if self.known is not None and self._ahead:
            self.known.case = case
        else:
            self._forget()
        self._between = self._ahead = False

    def _forget(self) -> None:
        if not self._of_any_case:
            self.known = None


def _not_there(recording: Recording, text: str, where: str) -> HilbenchError:
    if recording.problem is not None:
        return UnavailableError(f"{text}: {recording.problem}", where=where)
    return UsageError(text, where=where, hint="" if text.startswith("ends") else _NO_WORLD)


def _moment(known: _Known) -> Moment:
    stage = Stage.from_data(known.scene)
    start = stage.scene.start
    at_start = Pose(position_m=(start.x_m, start.y_m, start.z_m), yaw_rad=start.yaw_rad)
    seen = [(known.ns, at_start)] if known.starts else []
    seen += ((ns, pose_of(event)) for ns, event in known.poses)
    track = tuple(pose.position_m[:2] for _, pose in seen)
    ns, pose = seen[-1]
    return Moment(ns=ns, case=known.case, stage=stage, pose=pose, track=track)


def pose_of(event: Event) -> Pose:
    """Return the pose that an event tells of.

    Raises:
        WorldError: it is damaged.
    """
    values = [event.get(name) for name in ("x_m", "y_m", "z_m", "yaw_rad")]
    if not all(type(value) is int and abs(value) * _MILLIONTH < FARTHEST_M for value in values):
        raise WorldError(f"the pose at {event['ns']} ns is damaged")
    x_m, y_m, z_m, yaw_rad = (value * _MILLIONTH for value in values if value is not None)
    return Pose(position_m=(x_m, y_m, z_m), yaw_rad=yaw_rad)
