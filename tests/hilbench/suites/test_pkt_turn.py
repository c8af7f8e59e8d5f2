"""Whether all that 0x82 says is of one turn: no right sensor is accused, however it lies, and no wrong one passes."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from hilbench.check import Inconclusive
from hilbench.clock import NS_PER_S
from hilbench.suites.pkt_board._turn import disagreement
from protocols.pkt import ImuReport
from targets.robots.rover import Rocking, Sensed
from tests.each import each
from worlds.geometry import rotation, turn_back

STILL = Sensed(field_mgauss=(180.0, 40.0, -140.0), temperature_c=25.0)


def product(p, q):
    """The product of two quaternions, scalar last."""
    x, y, z, w = p
    a, b, c, d = q
    return (
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    )


def conjugate(q):
    return (-q[0], -q[1], -q[2], q[3])


def plus(vector, other):
    return tuple(one + two for one, two in zip(vector, other, strict=True))


def turned(change=lambda report, _late: report, *, period_s=8.0, sweep_deg=75.0, begin_s=0.3, count=9):
    """What is told of a turn about each axis; `change` gets each report, and what was told 0.4 s before it."""
    told = []
    for axis in (2, 0, 1):
        rocking = Rocking(axis=axis, period_s=period_s, sweep_deg=sweep_deg)

        def report(at_s, rocking=rocking):
            sensed = rocking.sensed(STILL, round(at_s * NS_PER_S))
            w, *xyz = sensed.attitude_wxyz
            return ImuReport(
                validity=3,
                acceleration=sensed.acceleration_m_s2,
                rate_deg_s=sensed.rate_deg_s,
                field_mgauss=sensed.field_mgauss,
                temperature_c=25.0,
                quaternion=(*xyz, w),
            )

        times = [begin_s + number for number in range(count)]
        told.append([(round(at_s * NS_PER_S), change(report(at_s), report(at_s - 0.4))) for at_s in times])
    return told


# --- right ones


def mounted(yaw, pitch, roll):
    """The sensor lies otherwise in the rover."""
    matrix = rotation(yaw, pitch, roll)
    about = [(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)), (0.0, math.sin(pitch / 2), 0.0, math.cos(pitch / 2))]
    lies = product(product(about[0], about[1]), (math.sin(roll / 2), 0.0, 0.0, math.cos(roll / 2)))

    def change(report, _late):
        return replace(
            report,
            acceleration=turn_back(matrix, report.acceleration),
            rate_deg_s=turn_back(matrix, report.rate_deg_s),
            field_mgauss=turn_back(matrix, report.field_mgauss),
            quaternion=product(report.quaternion, lies),
        )

    return change


def shaken(report, _late):
    draw = random.Random(repr(report)).gauss
    return replace(
        report,
        acceleration=plus(report.acceleration, [0.6 * draw(0, 1) for _ in range(3)]),
        rate_deg_s=plus(report.rate_deg_s, [4.0 + draw(0, 1) for _ in range(3)]),
        field_mgauss=plus(report.field_mgauss, [5.0 * draw(0, 1) for _ in range(3)]),
    )


RIGHT = {
    "as the model": lambda report, _late: report,
    "upside down": mounted(0.0, 0.0, math.pi),
    "askew": mounted(0.7, -0.4, 1.1),
    "its compass as the AK8963 lies": lambda report, _late: replace(
        report, field_mgauss=(report.field_mgauss[1], report.field_mgauss[0], -report.field_mgauss[2])
    ),
    "its attitude from the earth": lambda report, _late: replace(report, quaternion=conjugate(report.quaternion)),
    "its attitude as north, east, down": lambda report, _late: replace(
        report, quaternion=product((math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0), report.quaternion)
    ),
    "the other quaternion of the same attitude": lambda report, _late: replace(
        report, quaternion=tuple(-part for part in report.quaternion)
    ),
    "iron beside its compass": lambda report, _late: replace(
        report, field_mgauss=plus(report.field_mgauss, (300.0, -250.0, 150.0))
    ),
    "gravity downwards": lambda report, _late: replace(report, acceleration=tuple(-one for one in report.acceleration)),
    "with its offsets": lambda report, _late: replace(
        report, acceleration=plus(report.acceleration, (0.6, -0.6, 0.8)), rate_deg_s=plus(report.rate_deg_s, (5, -5, 5))
    ),
    "without a compass": lambda report, _late: replace(report, validity=1, field_mgauss=(0.0, 0.0, 0.0)),
    "in a hand that shakes": shaken,
    "a filter that is late": lambda report, late: replace(report, quaternion=late.quaternion),
}


@each("change", RIGHT.values())
def test_no_right_sensor_is_accused(change):
    for period_s, sweep_deg, begin_s in ((8.0, 75.0, 0.3), (6.0, 60.0, 0.0), (12.0, 80.0, 0.9)):
        told = turned(change, period_s=period_s, sweep_deg=sweep_deg, begin_s=begin_s)
        assert disagreement(told) == ""


# --- wrong ones


def one(field, index, change):
    """Another figure in a field, made of what the field says."""

    def changed(report, _late):
        values = [*getattr(report, field)]
        values[index] = change(values)
        return replace(report, **{field: tuple(values)})

    return changed


def exchanged(field, index):
    def changed(report, _late):
        values = [*getattr(report, field)]
        values[index : index + 2] = values[index + 1], values[index]
        return replace(report, **{field: tuple(values)})

    return changed


FIELDS = {"acceleration": 3, "rate_deg_s": 3, "field_mgauss": 3}
WRONG = {
    **{
        f"{field}[{index}] {what}": one(field, index, change)
        for field, size in FIELDS.items()
        for index in range(size)
        for what, change in (
            ("with the other sign", lambda values, index=index: -values[index]),
            ("as it was", lambda _values, still=(9.8 if (field, index) == ("acceleration", 2) else 0.0): still),
        )
    },
    **{f"{field}[{index}] for the next": exchanged(field, index) for field in FIELDS for index in range(2)},
    "quaternion[0] for the next": exchanged("quaternion", 0),
    "quaternion[1] for the next": exchanged("quaternion", 1),
    "scalar first": lambda report, _late: replace(report, quaternion=(report.quaternion[3], *report.quaternion[:3])),
    "rates in rad/s": lambda report, _late: replace(
        report, rate_deg_s=tuple(math.radians(rate) for rate in report.rate_deg_s)
    ),
}


@each("name", WRONG)
def test_a_wrong_sensor_is_found(name):
    assert disagreement(turned(WRONG[name]))


def test_what_is_not_turned_or_has_no_attitude_says_nothing():
    for told in (turned(sweep_deg=4.0), turned(lambda report, _late: replace(report, quaternion=(0.0,) * 4))):
        with pytest.raises(Inconclusive):
            disagreement(told)
