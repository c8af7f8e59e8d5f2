"""The drives: the rover's program on its emulated board, wheels in the air, throttle after throttle and set point."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo, CaseSetup
from hilbench.mcu.board_provider import BoardProvider
from hilbench.suites._rover_law import Driven, settled_rpm
from hilbench.suites._rover_motion import Ride
from protocols.pkt import MotionReport, PidGains, RequestTelemetry

UPWARDS = [round(0.20 + 0.01 * step, 2) for step in range(20)] + [0.4, 0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]
DOWNWARDS = [0.8, 0.6, 0.5, 0.4] + [round(0.39 - 0.01 * step, 2) for step in range(22)]
FIRST_S, HOLD_S = 2.0, 1.5
"""Where a wheel has just broken away it takes its time."""

SAMPLE_S, STEP_S = 0.02, 4.0
SAMPLES_A_REQUEST = 20
LEFT_FRONT, RIGHT_FRONT = 0, 1

TUNED = PidGains(kp=0.003, kd=0.0, ki=0.006)


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """A set point that is commanded to wheels at rest.

    Attributes:
        name: what it is filed under.
        set_point_rpm: of both sides.
        program: of the bench.
        gains: sent before; None for those at power-up.
        settings: of parts.
        held: whether all wheels are held.
        lasts_s: how long it is watched.
    """

    name: str
    set_point_rpm: float
    program: str = "documented"
    gains: PidGains | None = None
    settings: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    held: bool = False
    lasts_s: float = STEP_S


SPURIOUS = {"tacho_rf": {"extra_pulses": 7}}
"""The original's right front disc counted seven to eight times as much as the others in one session."""

STEPS = (
    *(Step(name=f"power-up {rpm}", set_point_rpm=rpm) for rpm in (30, 60, 120)),
    *(Step(name=f"tuned {rpm}", set_point_rpm=rpm, gains=TUNED) for rpm in (30, 60, 120)),
    *(Step(name=f"published {rpm}", set_point_rpm=rpm, program="g2") for rpm in (30, 50)),
    Step(name="published 30, spurious edges", set_point_rpm=30, program="g2", settings=SPURIOUS),
    Step(name="held", set_point_rpm=30, program="g2", held=True, lasts_s=0.6),
)


def sweep(throttles: list[float], start: float = 0.0) -> list[dict[str, float]]:
    """Return the wheels' speeds at one throttle after the other, each with that of the law."""
    found = []
    with _opened() as ride:
        if start:
            ride.drive(start, start, FIRST_S)
        for throttle in throttles:
            ride.drive(throttle, throttle, FIRST_S if throttle < UPWARDS[10] else HOLD_S)
            rpm = ride.rpm()[LEFT_FRONT]
            law_rpm = settled_rpm(Driven(throttle=throttle, start_rpm=rpm))
            found.append({"throttle": throttle, "rpm": round(rpm, 1), "law_rpm": round(law_rpm, 1)})
    return found


def course(step: Step) -> dict[str, Any]:
    """Return speeds and throttles of both sides after a set point is commanded, each `SAMPLE_S`, and what 0x83 said."""
    names = ("rpm_left", "rpm_right", "throttle_left", "throttle_right")
    columns: dict[str, list[float]] = {name: [] for name in names}
    with _opened(step) as ride:
        if step.gains is not None:
            ride.rover.send(step.gains)
        if step.held:
            ride.rover.hands.hold_wheels(True)
        ride.go(0.1)
        start_ns = ride.now.at_ns
        mark = ride.rover.mark()
        ride.keep(step.set_point_rpm, step.set_point_rpm)
        for number in range(round(step.lasts_s / SAMPLE_S)):
            if number % SAMPLES_A_REQUEST == 0:
                ride.rover.peer.send(RequestTelemetry())
            ride.rover.peer.run(SAMPLE_S)
            rpm = ride.rpm(SAMPLE_S)
            sample = (rpm[LEFT_FRONT], rpm[RIGHT_FRONT], *ride.rover.hands.duties())
            for name, value in zip(names, sample, strict=True):
                columns[name].append(round(value, 3))
        return {
            "set_point_rpm": step.set_point_rpm,
            "sample_s": SAMPLE_S,
            **columns,
            "reports": _said(ride, mark, start_ns),
        }


def _said(ride: Ride, mark: int, start_ns: int) -> list[dict[str, float]]:
    return [
        {
            "s": round((got.start_ns - start_ns) / 1e9, 3),
            "rpm_left": round(report.rpm[LEFT_FRONT], 2),
            "throttle_left": round(report.throttles[0], 4),
        }
        for got, report in ride.rover.peer.since(mark, MotionReport)
    ]


@contextlib.contextmanager
def _opened(step: Step | None = None) -> Iterator[Ride]:
    """Open the bench as a suite does."""
    setup = CaseSetup(program=step.program if step else "documented", settings=step.settings if step else {})
    shared = Shared(bench_file=open_bench("rover"), timeout_scale=1.0, journal=Journal())
    info = CaseInfo(id="plots/drive", clause_ids=(), seed=0, setup=setup)
    with BoardProvider(shared).open_case(info) as bench:
        yield Ride(bench)
        bench.finish("pass", "")
