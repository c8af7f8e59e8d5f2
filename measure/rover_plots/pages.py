"""The page, made from the record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hilbench.suites.rover_motion.set_points import KI, KP
from hilbench.suites.rover_motion.throttles import ORIGINAL_RPM

_HEAD = """\
# How the rover's wheels follow throttles and set points

Made by `make plots` (`python -m measure.rover_plots`); the data is in [rover-motion.json](rover-motion.json). Do not
edit.

Everything here is the bench `rover`: the program on the emulated board, its pulses through driver and motors,
wheels in the air (scene `stand`), full cells. *Original* is the rover of `nhorro/ceai2020`, of which its notebooks
show the wheels in the air and nothing on a floor. What is required of all this is in
[rover-clauses.md](rover-clauses.md), what the parts are in [rover-vehicle.md](rover-vehicle.md).

## Throttle to speed

![Wheel speed over throttle, here and of the original](images/rover-throttle.png)

"""

_CURVE = """
Each throttle is held for 1.5 s, 2 s where wheels have just broken away. *Law* is what `rover-motion` holds the
bench to, reckoned from the same figures in another way. Between the throttles of stopping and of breakaway a wheel
turns or stands, as it did before.

What differs, and which assumed figures it hangs on:

- At 0.25 the wheels here are slower than the original's, by 2 to 7 rpm; from 0.30 on they are within 1 rpm of its
  range. So near to where a wheel stops, its speed is decided by dry friction: `breakaway_torque_nm`,
  `running_torque_nm` and `friction_speed_rad_s` of `dc-motor`, three figures for which nothing but these notebooks
  speaks. Other sets of them would fit as well.
- The voltage is that of full cells (`charge` and `resistance_ohm` of `battery`), less a driver's typical drops
  (`drop_1a_v`, `drop_2a_v` of `l298n`). Nobody has written down how full the original's were; a tenth of their
  charge left takes a quarter of the speed at full throttle.
- Above 0.41 the original shows nothing that could be held against this: its firmware shows 0 for more than 150 rpm.
- All four wheels are alike here. The original's scatter is not known; its ranges of 3 to 5 rpm may be just that.
- How long it takes to a speed is decided by `rotor_inertia_kg_m2` of the vehicle (assumed), for which there is
  nothing of the original.

## Set points

![Speeds and throttles after set points are commanded, with three sets of gains and defects](images/rover-pid.png)

"""

_SET_POINTS = """
*Settles* is the mean of the last second where the speed stays within 6 rpm in it and turns the right way.

- **With the gains at power-up** nothing settles at its set point. The speed control is a proportional one, nearly:
  a throttle of {kp:g} for each missing rpm, while the sum takes 100 s to make as much ({ki:g} for each rpm and
  second). Where it settles, the error is what the throttle needs.
- **At 30 rpm it runs away backwards.** Tachometers see no direction, so the program takes the sign of the throttle
  for that of the wheel. Coming down from an overshoot the throttle becomes negative while the wheel still turns
  forward. From then on the speed counts as -30 rpm and as 30 rpm by turns: an error of 60 rpm makes a throttle of
  0.9, the next one of 0, by its fall, one of -0.3, fifty times a second. The pins that choose the direction follow
  at once, the length of a pulse with the next pulse, so each direction gets the length that was meant for the
  other, and the wheel turns backward at just the speed of the set point. 0x83, whose speeds have no sign, shows 30
  rpm. The original's runs at 20 to 50 rpm never settle, with throttles seen from -1 to 1: the same, as far as one
  can say of so little.
- **With gains that fit** it settles at 30, 60 and 120 rpm. They are a choice, made for these motors.
- **With the defects of the published firmware** (image `rover-g2`: speeds are held for a second after the last
  slot, more than 150 rpm count as 0, the sum goes on at the limits) it is much the same at 30 rpm, and 50 rpm goes
  on swinging.
- **Spurious edges** of one tachometer, as the original's right front one had in one session (seven to eight times
  as many as the others): its wheel is shown as 0 above 150 rpm, and the slower wheel of a side counts, so that side
  runs away.
- **Held wheels** give the throttle that the original's sources give when they are run on a computer: 0.3008 after
  0.25 s and 0.3015 after 0.5 s. Here: {held}.

Where the swings begin and how wide they are hangs on the same assumed friction and inertia as above, and on the
phase between the speed control at 50 Hz and the pulses at 50 Hz, which decides how late a throttle becomes a
voltage: up to 20 ms. Another moment of the command gives other swings.
"""


def page(record: Mapping[str, Any]) -> str:
    """Return the page."""
    return _HEAD + _speeds(record) + _CURVE + _courses(record["steps"]) + _explained(record["steps"])


def _speeds(record: Mapping[str, Any]) -> str:
    up, down = ({point["throttle"]: point for point in record[way]} for way in ("up", "down"))
    lines = ["| Throttle | Original, rpm | Here upwards | Here downwards | Law upwards |", "|--:|--:|--:|--:|--:|"]
    for throttle in (0.2, 0.22, 0.23, *sorted(ORIGINAL_RPM), 0.5, 0.8):
        here, law = f"{up[throttle]['rpm']:.0f}", f"{up[throttle]['law_rpm']:.0f}"
        lines.append(f"| {throttle:.2f} | {_original(throttle)} | {here} | {down[throttle]['rpm']:.0f} | {law} |")
    return "\n".join(lines) + "\n"


def _original(throttle: float) -> str:
    if throttle in ORIGINAL_RPM:
        low, high = ORIGINAL_RPM[throttle]
        return f"{low:.0f} to {high:.0f}" if high > low else f"{low:.0f}"
    return {0.2: "stops, on the way down", 0.23: "breaks away, on the way up", 0.5: "shows 0"}.get(throttle, "-")


def _courses(steps: Mapping[str, Any]) -> str:
    lines = [
        "| Gains, program | Set point, rpm | Settles, rpm | Speeds in the last second | Throttles in 0x83 |",
        "|---|--:|--:|--:|--:|",
    ]
    for name, course in steps.items():
        if name == "held":
            continue
        speeds = course["rpm_left"][-round(1 / course["sample_s"]) :]
        low, high = min(speeds), max(speeds)
        settled = f"{sum(speeds) / len(speeds):.1f}" if high - low < 6 and low > 0 else "no"
        said = [report["throttle_left"] for report in course["reports"]]
        what = name.rsplit(" ", 1)[0] if "," not in name else "published, spurious edges, left"
        lines.append(
            f"| {what} | {course['set_point_rpm']:.0f} | {settled} | {low:.0f} to {high:.0f} "
            f"| {min(said):.2f} to {max(said):.2f} |"
        )
    return "\n".join(lines) + "\n"


def _explained(steps: Mapping[str, Any]) -> str:
    reports: Sequence[Mapping[str, float]] = steps["held"]["reports"]
    held = ", ".join(f"{report['throttle_left']:.4f} after {report['s']:.2f} s" for report in reports[1:])
    return _SET_POINTS.format(kp=KP, ki=KI, held=held)
