"""What the adapter makes of a SIP on its wires: obstacle bits from the sonar, sector numbers from the odometry.

Published formulas (bluepill_comm.cpp): obstacle bit i is sonar i - 1 against a threshold, DD1 is forced low, DD7 and
DD8 are no outputs. The encoder numbers come from the distance d to the start and the direction b = atan2(y, x) of the
place: (d -/+ b * 0.5 / 2) / 0.1, of which the fraction is cut into eight: eight numbers for one rad of a wheel, and
none of it an angle of a wheel. Both are written when they change, and are low from the start.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from protocols.p2os import Pose
from targets.parts.p2os_adapter.events import DistanceBits, EncoderWords
from targets.parts.p2os_adapter.settings import P2osAdapterSettings
from targets.parts.part import DigitalOutput
from targets.parts.words import BitOrder, bits_of

__all__ = ["DistanceWires", "EncoderWires", "published_words"]

_DRIVEN = 6
_SECTORS = 8


class DistanceWires:
    """The wires DD1 to DD8.

    Args:
        settings: of the adapter.
        outputs: DD1 to DD8.
        tell: takes the events.
    """

    def __init__(
        self, settings: P2osAdapterSettings, outputs: Sequence[DigitalOutput], tell: Callable[[object], None]
    ) -> None:
        self._settings = settings
        self._outputs = outputs[: None if settings.dd7_8_driven else _DRIVEN]
        self._tell = tell
        self._bits = 0

    def start(self, now_ns: int) -> None:
        """Drive low what is driven."""
        for output in self._outputs:
            output.set(False, now_ns)

    def update(self, ranges_mm: Mapping[int, float], now_ns: int) -> None:
        """Take new sonar readings, by disc; those of other discs stay."""
        bits = self._bits
        for number, range_mm in ranges_mm.items():
            if 0 <= number < len(self._outputs):
                bits = bits & ~(1 << number) | self._high(number, range_mm) << number
        changed = bits ^ self._bits
        if not changed:
            return
        self._bits = bits
        for number, output in enumerate(self._outputs):
            if changed >> number & 1:
                output.set(bool(bits >> number & 1), now_ns)
        self._tell(DistanceBits(bits=bits))

    def _high(self, number: int, range_mm: float) -> bool:
        if number == 0 and self._settings.dd1_forced_low:
            return False
        beyond = round(range_mm) / 1000 > self._settings.distance_threshold_m
        return beyond is (self._settings.distance_sense == "far")


class EncoderWires:
    """The wires s1 to s3 of both encoders.

    Args:
        settings: of the adapter.
        left: outputs s1 to s3 of encoder 1.
        right: the same of encoder 2.
        tell: takes the events.
    """

    def __init__(
        self,
        settings: P2osAdapterSettings,
        left: Sequence[DigitalOutput],
        right: Sequence[DigitalOutput],
        tell: Callable[[object], None],
    ) -> None:
        self._settings = settings
        self._order: BitOrder = settings.encoder_order
        self._left, self._right = left, right
        self._tell = tell
        self._words = (0, 0)
        self._last = Pose()
        self._way_m = (0.0, 0.0)

    def start(self, now_ns: int) -> None:
        """Drive all low."""
        for output in (*self._left, *self._right):
            output.set(False, now_ns)

    def restart(self) -> None:
        """The odometry begins anew at zero, the wheels stand where they stood."""
        self._last = Pose()

    def update(self, pose: Pose, now_ns: int) -> None:
        """Take the next pose by odometry."""
        words = published_words(pose, self._settings) if self._published else self._wheel_words(pose)
        if words == self._words:
            return
        for outputs, word, old in zip((self._left, self._right), words, self._words, strict=True):
            for output, level, touched in zip(
                outputs, bits_of(word, self._order), bits_of(word ^ old, self._order), strict=True
            ):
                if touched:
                    output.set(level, now_ns)
        self._words = words
        self._tell(EncoderWords(left=words[0], right=words[1]))

    @property
    def _published(self) -> bool:
        return self._settings.encoder_form == "published"

    def _wheel_words(self, pose: Pose) -> tuple[int, int]:
        """Sectors of 45 degrees of the wheels, from the way that each has made since the start."""
        last, self._last = self._last, pose
        turned_rad = pose.heading_rad - last.heading_rad
        heading_rad = last.heading_rad + turned_rad / 2
        ahead_m = (
            (pose.x_mm - last.x_mm) * math.cos(heading_rad) + (pose.y_mm - last.y_mm) * math.sin(heading_rad)
        ) / 1000
        aside_m = turned_rad * self._settings.track_m / 2
        left_m, right_m = self._way_m
        self._way_m = (left_m + ahead_m - aside_m, right_m + ahead_m + aside_m)
        sector_m = self._settings.wheel_radius_m * 2 * math.pi / _SECTORS
        left, right = (math.floor(way_m / sector_m) % _SECTORS for way_m in self._way_m)
        return left, right


def published_words(pose: Pose, settings: P2osAdapterSettings) -> tuple[int, int]:
    """The numbers (left, right) that the published formula makes of a pose."""
    x_m, y_m = pose.x_mm / 1000, pose.y_mm / 1000
    aside_m = math.atan2(y_m, x_m) * settings.encoder_base_m / 2
    distance_m = math.hypot(x_m, y_m)
    left, right = (
        math.trunc(math.fmod(way_m / settings.encoder_radius_m, 1.0) * _SECTORS) % _SECTORS
        for way_m in (distance_m - aside_m, distance_m + aside_m)
    )
    return left, right
