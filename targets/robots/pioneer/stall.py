"""The stall monitor: a wheel that is given much power and barely turns loses its power for a while.

As published for the P2OS family (Pioneer 2/3 H8 Operations Manual, StallVal and StallCount): the PWM of a wheel
slower than 100 mm/s is averaged over 500 ms, a faster wheel counting as zero; an average above StallVal is a stall.
Power is then removed for the stall time and comes back by itself. The PWM is taken from the motor's load, full load
being PwmMax.
"""

from __future__ import annotations

from collections import deque

from targets.robots.pioneer.settings import RobotSettings


class WheelStall:
    """The monitor of one wheel."""

    def __init__(self, settings: RobotSettings) -> None:
        self._settings = settings
        self._average_s = settings.stall_average_ms / 1000
        self._samples: deque[tuple[float, float]] = deque()  # (PWM x seconds, seconds), oldest first
        self._sum = 0.0
        self._span_s = 0.0
        self._until_ns: int | None = None

    @property
    def stalled(self) -> bool:
        """Whether the wheel's power is cut now; the stall bit of the SIP."""
        return self._until_ns is not None

    def clear(self) -> None:
        """Forget everything (motors switched off)."""
        self._samples.clear()
        self._sum = self._span_s = 0.0
        self._until_ns = None

    def update(self, load: float, speed_mm_s: float, now_ns: int, dt_s: float) -> None:
        """Take the motor load (0..1) and wheel speed at `now_ns`; they stand for the `dt_s` seconds that follow."""
        if self._until_ns is not None:
            if now_ns >= self._until_ns:
                self.clear()
            return
        slow = abs(speed_mm_s) < self._settings.stall_speed_mm_s
        self._add(load * self._settings.pwm_max * dt_s if slow else 0.0, dt_s)
        if self._sum / self._average_s > self._settings.stall_pwm:
            self.clear()
            self._until_ns = now_ns + self._settings.stall_wait_ms * 1_000_000

    def _add(self, pwm_seconds: float, dt_s: float) -> None:
        self._samples.append((pwm_seconds, dt_s))
        self._sum += pwm_seconds
        self._span_s += dt_s
        while self._span_s - self._samples[0][1] >= self._average_s:
            old, old_s = self._samples.popleft()
            self._sum -= old
            self._span_s -= old_s
