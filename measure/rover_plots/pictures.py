"""The pictures, by matplotlib, which is imported when something is drawn."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from hilbench.suites.rover_motion.throttles import ORIGINAL_RPM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE, RED, GREEN, GREY = "#0072b2", "#d55e00", "#009e73", "#888888"
"""Blue, vermilion and green of Okabe and Ito: told apart by everybody."""

BREAKAWAY, STOPS = 0.23, (0.19, 0.20)
"""Throttles at which the original's wheels begin to turn, and stop."""

SHOWN_RPM = 150.0
"""Above which the published firmware shows 0."""

DOTS_PER_INCH = 110


def pictures(record: Mapping[str, Any]) -> dict[str, bytes]:
    """Return the pictures as PNG, by name."""
    return {"rover-throttle.png": _png(_throttle(record)), "rover-pid.png": _png(_set_points(record["steps"]))}


def _png(figure: Figure) -> bytes:
    """The same bytes for the same figure: without a date, or who made it."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    return file.getvalue()


def _figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Figure, Any]:
    """A figure that no window and no global state of pyplot has to do with."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False)


# --- throttle to speed


def _throttle(record: Mapping[str, Any]) -> Figure:
    figure, axes = _figure(1, 2, (11.0, 4.6))
    for ax, limits in zip(axes[0], ((0.15, 0.42), (0.0, 1.02)), strict=True):
        _curve(ax, record["up"], BLUE, "o", "here, upwards")
        _curve(ax, record["down"], GREEN, "v", "here, downwards")
        _original(ax)
        ax.set_xlim(*limits)
        ax.set_xlabel("throttle")
        ax.set_ylabel("wheel speed, rpm")
        ax.grid(alpha=0.3)
    axes[0][0].set_ylim(-5, 160)
    axes[0][1].set_ylim(-5, 210)
    axes[0][1].annotate("the original shows 0 above this", (0.98, SHOWN_RPM + 3), ha="right", fontsize=8, color=RED)
    axes[0][0].legend(fontsize=8, loc="lower right")
    figure.suptitle("Wheels in the air: throttle to speed, pulses of 50 Hz, full cells")
    return figure


def _curve(ax: Axes, points: list[dict[str, float]], colour: str, marker: str, label: str) -> None:
    throttles = [point["throttle"] for point in points]
    ax.plot(throttles, [point["rpm"] for point in points], marker=marker, ms=4, lw=1, color=colour, label=label)


def _original(ax: Axes) -> None:
    """What its notebooks show: ranges of speeds, where it breaks away and stops, what it cannot show."""
    label = "original (notebooks)"
    for throttle, (low, high) in ORIGINAL_RPM.items():
        middle, half = (low + high) / 2, max((high - low) / 2, 1.0)
        ax.errorbar([throttle], [middle], yerr=[half], fmt="s", ms=5, mfc="none", color=RED, capsize=4, label=label)
        label = "_"
    ax.axvline(BREAKAWAY, color=RED, ls="--", lw=1, label="original breaks away, about 0.23")
    ax.axvspan(*STOPS, color=RED, alpha=0.15, label="original stops, 0.19 to 0.20")
    ax.axhline(SHOWN_RPM, color=RED, ls=":", lw=1)


# --- set points


def _set_points(steps: Mapping[str, Any]) -> Figure:
    figure, axes = _figure(3, 2, (11.0, 9.6))
    _column(axes, 0, {rpm: steps[f"power-up {rpm}"] for rpm in (30, 60, 120)}, "rpm_left", "throttle_left")
    _column(axes, 1, {rpm: steps[f"tuned {rpm}"] for rpm in (30, 60, 120)}, "rpm_left", "throttle_left")
    axes[0][0].set_title("gains at power-up: kp 0.01, kd 0.0001, ki 0.0001", fontsize=10)
    axes[0][1].set_title("gains by RESET_PID: kp 0.003, kd 0, ki 0.006", fontsize=10)
    _published(axes[2][0], steps["published 30"], steps["published 50"])
    _spurious(axes[2][1], steps["published 30, spurious edges"])
    for ax in axes.flat:
        ax.set_xlim(0, 4)
        ax.grid(alpha=0.3)
    for ax in axes[2]:
        ax.set_xlabel("time from the command, s")
    figure.suptitle("Wheels in the air: set points commanded at rest (true speeds; + forward)")
    return figure


def _column(axes: Any, column: int, courses: Mapping[int, Mapping[str, Any]], speed: str, throttle: str) -> None:
    fast, driven = axes[0][column], axes[1][column]
    for colour, (rpm, course) in zip((BLUE, GREEN, GREY), courses.items(), strict=True):
        fast.plot(_times(course), course[speed], color=colour, lw=1.2, label=f"set point {rpm} rpm")
        fast.axhline(rpm, color=colour, ls=":", lw=1)
        driven.plot(_times(course), course[throttle], color=colour, lw=0.8, alpha=0.7)
        reports = course["reports"]
        at_s, said = [report["s"] for report in reports], [report["throttle_left"] for report in reports]
        driven.plot(at_s, said, "o", ms=4, color=colour, label=f"in 0x83, set point {rpm} rpm")
    _throttle_axis(driven)
    fast.set_ylim(-60, 185)
    fast.set_ylabel("left wheels, rpm")
    fast.legend(fontsize=8, loc="upper right")


def _throttle_axis(ax: Axes) -> None:
    for limit in (-1.0, 1.0):
        ax.axhline(limit, color=RED, ls="--", lw=1)
    text = "range of the original's throttles in 0x83 at 20 to 50 rpm"
    ax.annotate(text, (3.95, -0.96), ha="right", fontsize=8, color=RED)
    ax.set_ylim(-1.15, 1.9)
    ax.set_ylabel("left: at the driver, and in 0x83")
    ax.legend(fontsize=8, loc="upper right")


def _published(ax: Axes, *courses: Mapping[str, Any]) -> None:
    for colour, course in zip((BLUE, GREEN), courses, strict=True):
        ax.plot(
            _times(course), course["rpm_left"], color=colour, lw=1, label=f"set point {course['set_point_rpm']} rpm"
        )
        ax.axhline(course["set_point_rpm"], color=colour, ls=":", lw=1)
    ax.set_ylim(-60, 140)
    ax.set_ylabel("left wheels, rpm")
    ax.set_title("with the defects of the published firmware", fontsize=10)
    ax.legend(fontsize=8, loc="upper right")


def _spurious(ax: Axes, course: Mapping[str, Any]) -> None:
    ax.plot(_times(course), course["rpm_left"], color=BLUE, lw=1, label="left wheels")
    ax.plot(_times(course), course["rpm_right"], color=RED, lw=1, label="right wheels")
    ax.axhline(course["set_point_rpm"], color=GREY, ls=":", lw=1)
    ax.set_ylim(-60, 140)
    ax.set_ylabel("wheels, rpm")
    ax.set_title("the same, eight edges a slot at the right front tachometer", fontsize=10)
    ax.legend(fontsize=8, loc="center right")


def _times(course: Mapping[str, Any]) -> list[float]:
    return [course["sample_s"] * (number + 1) for number in range(len(course["rpm_left"]))]
