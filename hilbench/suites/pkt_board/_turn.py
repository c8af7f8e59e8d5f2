"""A turn, as the figures of several 0x82 tell it: its rates, its attitude, its acceleration and its field agree.

Nothing is known of how the sensor lies in the rover, of the frame that its attitude is told in, or of iron beside it:
all is compared within the axes of one and the same sensor. Its compass may have them as the AK8963 does, with x and y
exchanged and z the other way (PS-MPU-9250A-01, section 9.1), and its quaternion may lead to the earth or from it.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Sequence
from itertools import pairwise

from hilbench.check import Inconclusive
from hilbench.clock import NS_PER_S
from protocols.pkt import ImuReport
from worlds.geometry import Vector, add, cross, dot, subtract

__all__ = ["Told", "disagreement"]

Told = Sequence[tuple[int, ImuReport]]
"""What was told while something was turned to and fro about one axis: reports with their times in ns."""
Four = tuple[float, float, float, float]

LEAST, MOST = 0.4, 2.5
"""Of what a turn does to one figure, as a share of what it does to another. Between two reports a rate is taken for the
mean of both, which for a turn to and fro in 4 s is 0.64 of what it is, and a filter may be late (choices)."""
ASIDE = 0.5
"""Which share of a figure may go another way than the turn: whoever turns it wobbles (choice)."""
STEP_DEG = 10.0
"""Root mean square of the steps of a turn from which something is concluded: more than a gyroscope's offset, 5 deg/s in
the data sheet (PS-MPU-9250A-01, section 3.1), makes of one that stands."""
SHAKEN_M_S2, SHAKEN_SHARE = 2.5, 0.35
"""How far off its mean the length of the acceleration may be, root mean square: a hand shakes it by less than a quarter
of 1 g; and that of the field, as a share: iron beside it bends it (choices)."""
COMPASS_READ = 2
"""Bit of the validity: without it the field says nothing."""
SEEN_M_S2, SEEN_MGAUSS = 2.5, 30.0
"""Root mean square of the steps of a vector from which something is concluded: much more than its noise (choice)."""


def disagreement(turns: Sequence[Told]) -> str:
    """Say how what was told in some turns, each about one axis, is not of the same turns; empty if it is.

    Raises:
        Inconclusive: the attitude does not change enough.
    """
    to_earth, from_earth = (_disagreement(turns, conjugate) for conjugate in (False, True))
    return to_earth if from_earth else ""


def _disagreement(turns: Sequence[Told], conjugate: bool) -> str:
    steps = [_steps(told, conjugate) for told in turns]
    return _of_rates(turns, steps) or _of_acceleration(turns, steps) or _of_field(turns, steps)


def _of_rates(turns: Sequence[Told], steps: Sequence[Sequence[Vector]]) -> str:
    for told, step in zip(turns, steps, strict=True):
        turned_deg = _rms(map(_length, step))
        if turned_deg < STEP_DEG:
            raise Inconclusive(f"it was turned by {turned_deg:.1f} degrees a second only")
        rates = [
            _scaled(add(before.rate_deg_s, now.rate_deg_s), (now_ns - before_ns) / NS_PER_S / 2)
            for (before_ns, before), (now_ns, now) in pairwise(told)
        ]
        if why := _other(rates, step):
            return f"the rates of 0x82 and its attitude are not of one turn: {why}"
    return ""


def _of_acceleration(turns: Sequence[Told], steps: Sequence[Sequence[Vector]]) -> str:
    accelerations = [[report.acceleration for _, report in told] for told in turns]
    if why := _turns_otherwise(accelerations, steps, (0.0, 0.0, 0.0), SEEN_M_S2):
        return f"the acceleration of 0x82 does not turn as its attitude does: {why}"
    off = max(map(_uneven, accelerations))
    return f"the length of the acceleration in 0x82 is {off:.1f} m/s^2 off its mean" if off > SHAKEN_M_S2 else ""


def _of_field(turns: Sequence[Told], steps: Sequence[Sequence[Vector]]) -> str:
    if not all(report.validity & COMPASS_READ for told in turns for _, report in told):
        return ""
    as_it_is, as_of_compass = (
        _of_field_along([[way(report.field_mgauss) for _, report in told] for told in turns], steps)
        for way in (_as_it_is, _as_of_compass)
    )
    return f"the field of 0x82 does not turn as its attitude does: {as_it_is}" if as_it_is and as_of_compass else ""


def _of_field_along(fields: Sequence[Sequence[Vector]], steps: Sequence[Sequence[Vector]]) -> str:
    iron = _iron(fields, steps)
    if why := _turns_otherwise(fields, steps, iron, SEEN_MGAUSS):
        return why
    turned = [subtract(one, iron) for field, step in zip(fields, steps, strict=True) for one in field]
    mean = statistics.fmean(map(_length, turned))
    off = _uneven(turned) / mean if mean > SEEN_MGAUSS else 0.0
    return f"its length is {off:.0%} off its mean" if off > SHAKEN_SHARE else ""


def _turns_otherwise(
    vectors: Sequence[Sequence[Vector]], steps: Sequence[Sequence[Vector]], still: Vector, seen: float
) -> str:
    """Say how a vector of the world, less one of the sensor, does not turn the other way than the sensor does."""
    for told, step in zip(vectors, steps, strict=True):
        changes, wanted = [], []
        for (before, now), turn in zip(pairwise(told), step, strict=True):
            changes.append(subtract(now, before))
            middle = subtract(_scaled(add(before, now), 0.5), still)
            wanted.append(_scaled(cross(turn, middle), -math.radians(1.0)))
        if _rms(map(_length, wanted)) > seen:
            if why := _other(changes, wanted) or _along_an_axis(changes, wanted, seen):
                return why
        elif _rms(map(_length, changes)) > 2 * seen:
            return "it changes, and the turn does not say so"
    return ""


def _along_an_axis(found: Sequence[Vector], wanted: Sequence[Vector], seen: float) -> str:
    """Say along which axis alone one row of vectors is not the other."""
    for axis, name in enumerate("xyz"):
        row = [one[axis] for one in wanted]
        share = sum(one[axis] * other for one, other in zip(found, row, strict=True)) / max(
            seen**2, sum(value * value for value in row)
        )
        if _rms(row) > seen and not LEAST <= share <= MOST:
            return f"a share of {share:.2f} along {name}, required {LEAST:g} to {MOST:g}"
    return ""


def _other(found: Sequence[Vector], wanted: Sequence[Vector]) -> str:
    """Say how one row of vectors is not the other, less a factor; empty if it is."""
    size = sum(dot(one, one) for one in wanted)
    share = sum(dot(one, other) for one, other in zip(found, wanted, strict=True)) / max(size, 1e-9)
    if not LEAST <= share <= MOST:
        return f"a share of {share:.2f}, required {LEAST:g} to {MOST:g}"
    rest = [subtract(one, _scaled(other, share)) for one, other in zip(found, wanted, strict=True)]
    aside = (_rms(map(_length, rest)) / max(_rms(map(_length, found)), 1e-9)) ** 2
    return f"{aside:.0%} of it another way" if aside > ASIDE else ""


def _iron(fields: Sequence[Sequence[Vector]], steps: Sequence[Sequence[Vector]]) -> Vector:
    """Return the field that turns with the sensor: least squares of change + step x mean = step x iron."""
    rows = [*zip(((SMALL, 0.0, 0.0), (0.0, SMALL, 0.0), (0.0, 0.0, SMALL)), (0.0, 0.0, 0.0), strict=True)]
    for field, step in zip(fields, steps, strict=True):
        for (before, now), turn in zip(pairwise(field), step, strict=True):
            x, y, z = _scaled(turn, math.radians(1.0))
            middle = _scaled(add(before, now), 0.5)
            right = add(subtract(now, before), cross((x, y, z), middle))
            rows += zip(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)), right, strict=True)
    a, b, c = (_scaled_sum((row, row[i]) for row, _ in rows) for i in range(3))
    p, q, r = _scaled_sum(rows)
    return _scaled(_scaled_sum(((cross(b, c), p), (cross(c, a), q), (cross(a, b), r))), 1 / dot(a, cross(b, c)))


SMALL = 0.03
"""Keeps at 0 what a turn about one axis does not tell of the iron: along that axis."""


# --- vectors


def _steps(told: Told, conjugate: bool) -> list[Vector]:
    """Return by what the sensor turned from each report to the next, in degrees about its own axes."""
    return [_step(before.quaternion, now.quaternion, conjugate) for (_, before), (_, now) in pairwise(told)]


def _step(before: Four, now: Four, conjugate: bool) -> Vector:
    sign = -1.0 if conjugate else 1.0
    *u, a = before
    *v, b = now
    one, other = _scaled((u[0], u[1], u[2]), sign), _scaled((v[0], v[1], v[2]), sign)
    scalar = a * b + dot(one, other)
    vector = subtract(subtract(_scaled(other, a), _scaled(one, b)), cross(one, other))
    if scalar < 0:
        scalar, vector = -scalar, _scaled(vector, -1.0)
    size = _length(vector)
    return _scaled(vector, math.degrees(2 * math.atan2(size, scalar)) / size) if size else vector


def _as_it_is(vector: Vector) -> Vector:
    return vector


def _as_of_compass(vector: Vector) -> Vector:
    return vector[1], vector[0], -vector[2]


def _scaled(vector: Vector, factor: float) -> Vector:
    return vector[0] * factor, vector[1] * factor, vector[2] * factor


def _scaled_sum(parts: Iterable[tuple[Vector, float]]) -> Vector:
    total = (0.0, 0.0, 0.0)
    for vector, factor in parts:
        total = add(total, vector, factor)
    return total


def _length(vector: Sequence[float]) -> float:
    return math.hypot(*vector)


def _rms(values: Iterable[float]) -> float:
    return math.sqrt(statistics.fmean([value * value for value in values]))


def _uneven(vectors: Sequence[Vector]) -> float:
    """Return how far lengths are off their mean, root mean square."""
    lengths = [*map(_length, vectors)]
    mean = statistics.fmean(lengths)
    return _rms(length - mean for length in lengths)
