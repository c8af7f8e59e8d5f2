"""What a recording shows of its world at one moment: what stands there, where the vehicle is and where it has been."""

from __future__ import annotations

from dataclasses import dataclass

from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Recording
from hilbench.recordings.layout import Event, laid_out
from worlds.errors import WorldError
from worlds.stage import FARTHEST_M, Stage
from worlds.world import Pose

__all__ = ["Moment", "moment_of"]

_MILLIONTH = 1e-6
_NO_WORLD = "it has no world, or its beginning is in an older part of the journal (FILE.1)"


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
        at_ns: the time in it; None for its end.
        where: its name, for messages.

    Raises:
        UsageError: it ends before, or nothing stands in a world then.
        UnavailableError: what it says of its world is damaged.
    """
    case, began_ns, last_ns = "", 0, 0
    scene: Event | None = None
    poses: list[tuple[int, Event]] = []
    for ns, event in laid_out(recording.events):
        last_ns = ns
        if at_ns is not None and ns > at_ns:
            break
        match event["kind"]:
            case "case":
                case, scene = str(event["case"]), None
            case "scene":
                scene, poses, began_ns = event, [], ns
            case "pose":
                poses.append((ns, event))
    if at_ns is not None and last_ns < at_ns:
        raise UsageError(f"{where} ends at {last_ns / 1e9:.3f} s", where="--at")
    if scene is None:
        when = "" if at_ns is None else f" at {at_ns / 1e9:g} s" + (f", in case {case}" if case else "")
        raise UsageError(f"says of no vehicle where it stands{when}", where=where, hint=_NO_WORLD)
    try:
        return _moment(case, scene, poses, began_ns)
    except WorldError as error:
        raise UnavailableError(str(error), where=where) from error


def _moment(case: str, scene: Event, poses: list[tuple[int, Event]], began_ns: int) -> Moment:
    stage = Stage.from_data(scene)
    start = stage.scene.start
    pose = Pose(position_m=(start.x_m, start.y_m, start.z_m), yaw_rad=start.yaw_rad)
    seen = [(began_ns, pose), *((ns, _pose(event)) for ns, event in poses)]
    track = tuple(pose.position_m[:2] for _, pose in seen)
    ns, pose = seen[-1]
    return Moment(ns=ns, case=case, stage=stage, pose=pose, track=track)


def _pose(event: Event) -> Pose:
    values = [event.get(name) for name in ("x_m", "y_m", "z_m", "yaw_rad")]
    if not all(isinstance(value, int) and abs(value) * _MILLIONTH < FARTHEST_M for value in values):
        raise WorldError(f"the pose at {event['ns']} ns is damaged")
    x_m, y_m, z_m, yaw_rad = (value * _MILLIONTH for value in values if value is not None)
    return Pose(position_m=(x_m, y_m, z_m), yaw_rad=yaw_rad)
