"""What tachometers count, and the speeds they show."""

from __future__ import annotations

from hilbench.check import Inconclusive, near
from hilbench.clock import NS_PER_S
from hilbench.suites._rover_motion import LEFT, NAMES, RIGHT, Four, Ride, on_bench
from hilbench.suites.rover_motion._judged import LOOK_S, ride

__all__ = ["ride"]

SLOT = 1.5
"""How far a count may be from the angle: where the disc stood at first, and what passes while 0x83 goes out."""

RPM = 0.04
"""Tolerance of a speed in 0x83, as a share: speeds swing with the pulses. A choice."""


def require_ways_of_their_own(slots: Four) -> None:
    """Require what a wheel's count is told from another's by.

    Raises:
        Inconclusive: a wheel has not turned, or one as far as the other of its side.
    """
    ways = [abs(one) for one in slots]
    apart = [abs(ways[front] - ways[back]) for front, back in (LEFT, RIGHT)]
    if min(*ways, *apart) < 2 * SLOT:
        shown = ", ".join(f"{one:.0f}" for one in slots)
        raise Inconclusive(f"the wheels have turned by {shown} slots, not each by a way of its own")


@on_bench("R09", lasts_s=2.8)
def test_tachometers(ride: Ride) -> None:
    """Each wheel has its own way behind it: one of a side after the other is held."""
    ride.hold("lb")
    ride.drive(0.35, -0.8, 0.8)
    ride.hold("lb", held=False)
    ride.hold("rb")
    ride.go(0.4)
    ride.hold("rb", held=False)
    ride.go(1.2)
    at_ns, report = ride.motion()
    slots = ride.slots_at(at_ns)
    require_ways_of_their_own(slots)
    rpm = ride.at(at_ns).rpm_since(ride.at(at_ns - round(LOOK_S * NS_PER_S)))
    for place, name in enumerate(NAMES):
        ticks = report.ticks[place]
        near(ticks, abs(slots[place]), SLOT, unit="slots", what=f"ticks of the {name} wheel beside its true angle")
        speed_rpm = abs(rpm[place])
        near(report.rpm[place], speed_rpm, RPM * speed_rpm, unit="rpm", what=f"speed of the {name} wheel in 0x83")
