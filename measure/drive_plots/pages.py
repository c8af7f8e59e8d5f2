"""The page, with the figures of a lap and of an emergency stop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from statistics import fmean

from hilbench.suites._vehicle_drive import Drive, Moment
from measure.drive_plots.chart import Panel, chart
from measure.drive_plots.drives import SLOW_FROM_M_S, SLOW_S
from measure.mutants.vehicle.driven import DRIVEN
from worlds.above import COLOURS, Sheet, top_view
from worlds.car_parameters import DEFAULTS as CAR
from worlds.scenes import find_scene

__all__ = ["SLOW", "course", "page", "seen_from_above", "stopping"]

TEMPLATE = Path(__file__).parent / "page.txt"


SLOW = ((30.0, "vehicle"), (10.0, "vehicle"), (5.0, "vehicle"), (5.0, "vehicle-h7"))
"""How many commands a second, and the image on the board; `H7` sends the last command again, as the original does."""

HARD_M_S2 = 7.5
"""Full braking is 8 m/s²."""

FRAME_BYTES = 30
BAUD = 921_600
BLUE, VERMILION, GREEN = COLOURS


def page(lap: Drive, stop: Drive, lost_s: float, emergency_s: float, slow: Sequence[Sequence[Moment]]) -> str:
    """Return the page; `slow` are drives by the commands of `SLOW`."""
    offsets_m = [moment.offset_m for moment in lap.moments]
    speeds_m_s = [moment.speed_m_s for moment in lap.moments]
    lap_s = lap.moments[-1].at_s
    asked = [abs(command.steering_tire_angle) for _, command in lap.asked]
    begin, end, lost = (_at(stop, at_s) for at_s in (emergency_s, stop.moments[-1].at_s, lost_s))
    rest = next(moment for moment in stop.moments if moment.at_s > begin.at_s and moment.speed_m_s <= 1e-3)
    speed = begin.speed_m_s
    ideal_s, ideal_m = speed / CAR.max_decel_m_s2, speed**2 / (2 * CAR.max_decel_m_s2)
    stop_m, whole_m = _way_m(begin, end), _way_m(lost, end)
    whole_ideal_m = fmean([lost.speed_m_s, speed]) * (begin.at_s - lost.at_s) + ideal_m
    return TEMPLATE.read_text(encoding="utf-8").format(
        length_m=lap.path.length_m,
        lap_s=lap_s,
        mean_m_s=lap.path.length_m / lap_s,
        most_m_s=max(speeds_m_s),
        off_m=max(map(abs, offsets_m)),
        rms_m=math.sqrt(fmean(offset**2 for offset in offsets_m)),
        half_m=lap.half_lane_m,
        lateral=max(abs(moment.lateral_m_s2) for moment in lap.moments),
        share=fmean(abs(moment.steering_rad) for moment in lap.moments) / fmean(asked),
        asked=len(lap.asked),
        frames=len(lap.commanded()),
        speed=speed,
        silence_s=emergency_s - lost_s,
        silence_off=(emergency_s - lost_s - 1) * 1e3,
        ideal_s=ideal_s,
        stop_s=rest.at_s - begin.at_s,
        stop_off=(rest.at_s - begin.at_s - ideal_s) * 1e3,
        ideal_m=ideal_m,
        stop_m=stop_m,
        way_off=(stop_m - ideal_m) * 1e3,
        whole_ideal_m=whole_ideal_m,
        whole_m=whole_m,
        whole_off=(whole_m - whole_ideal_m) * 1e3,
        frame_us=FRAME_BYTES * 10 / BAUD * 1e6,
        slow_from=SLOW_FROM_M_S,
        slow_s=SLOW_S,
        slow="\n".join(_slow_row(*kind, moments) for kind, moments in zip(SLOW, slow, strict=True)),
        faulty="\n".join(f"| `{one.id}` | {one.what} | {', '.join(one.about)} |" for one in DRIVEN),
    )


def _slow_row(rate_hz: float, image: str, moments: Sequence[Moment]) -> str:
    """Speed, way and braking of a drive by few commands."""
    begin, end = moments[0], moments[-1]
    hard = [moment.accel_m_s2 < -HARD_M_S2 for moment in moments]
    times = sum(later and not earlier for earlier, later in pairwise(hard))
    jerk = max(abs(b.accel_m_s2 - a.accel_m_s2) / (b.at_s - a.at_s) for a, b in pairwise(moments))
    figures = (
        f"{rate_hz:.0f} Hz",
        "sent again (`H7`)" if image != "vehicle" else "a stop",
        f"{end.speed_m_s:.2f} m/s",
        f"{_way_m(begin, end):.1f} m",
        f"{max(0.0, *(-moment.accel_m_s2 for moment in moments)):.1f} m/s²",
        f"{times}",
        f"{100 * sum(hard) / len(hard):.0f} %",
        f"{jerk:.0f} m/s³",
    )
    return f"| {' | '.join(figures)} |"


def seen_from_above(lap: Drive) -> str:
    """The track with the lap."""
    front_m, half_m = CAR.front_bumper_m, CAR.width_m / 2
    outline = [(-CAR.rear_overhang_m, -half_m), (front_m, -half_m), (front_m, half_m), (-CAR.rear_overhang_m, half_m)]
    sheet = Sheet(
        title="A lap of the test track through the vehicle-interface board",
        px_per_m=5.5,
        bar_m=10,
        note="outline: the car at its start; orange dots: cones; grey: the wall",
    )
    tracks = {"rear axle, driven by the driving stack": [(moment.x_m, moment.y_m) for moment in lap.moments]}
    return top_view(find_scene("test-track", seed=0), tracks, [outline], sheet)


def course(lap: Drive) -> str:
    """Speed, offset and tyre angle over the way."""
    way_m, before = 0.0, lap.moments[0]
    rows: list[tuple[float, Moment]] = []
    for moment in lap.moments:
        way_m += _way_m(before, moment)
        before = moment
        rows.append((way_m, moment))
    planned = [(s_m, lap.driver.profile.speed_m_s(s_m)) for s_m in range(int(lap.path.length_m))]
    half = lap.half_lane_m
    return chart(
        "A lap: speed, offset and tyre angle",
        "way, m",
        range(0, 401, 50),
        [
            Panel(
                title="speed, m/s; grey: as planned",
                low=0,
                high=12,
                step=4,
                lines=[(planned, "#999999"), ([(way, one.speed_m_s) for way, one in rows], BLUE)],
            ),
            Panel(
                title="off the middle line, m, + left; shaded: within the lane",
                low=-1,
                high=1,
                step=0.5,
                lines=[([(way, one.offset_m) for way, one in rows], VERMILION)],
                band=(-half, half),
            ),
            Panel(
                title="tyre angle, degrees, + left",
                low=-12,
                high=12,
                step=6,
                lines=[([(way, math.degrees(one.steering_rad)) for way, one in rows], GREEN)],
            ),
        ],
    )


def stopping(stop: Drive, lost_s: float, emergency_s: float) -> str:
    """Speed and way over the time since the emergency's first frame."""
    begin = _at(stop, emergency_s)
    moments = [one for one in stop.moments if -1.5 <= one.at_s - emergency_s <= 2.0]
    speed = begin.speed_m_s
    formula = [(t / 100, max(0.0, speed - CAR.max_decel_m_s2 * t / 100)) for t in range(201)]
    lost = lost_s - emergency_s
    return chart(
        "An emergency stop",
        "time since the emergency's first frame, s",
        [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0],
        [
            Panel(
                title="speed, m/s; dark: the formula; grey lines: last status, emergency",
                low=0,
                high=12,
                step=4,
                lines=[
                    ([(lost, 0.0), (lost, 12.0)], "#999999"),
                    ([(0.0, 0.0), (0.0, 12.0)], "#999999"),
                    ([(one.at_s - emergency_s, one.speed_m_s) for one in moments], BLUE),
                    (formula, "#222222"),
                ],
            ),
            Panel(
                title="way since then, m",
                low=-16,
                high=8,
                step=8,
                lines=[([(one.at_s - emergency_s, one.x_m - begin.x_m) for one in moments], VERMILION)],
            ),
        ],
    )


def _at(drive: Drive, at_s: float) -> Moment:
    return drive.since(at_s)[0]


def _way_m(begin: Moment, end: Moment) -> float:
    return math.dist((begin.x_m, begin.y_m), (end.x_m, end.y_m))
