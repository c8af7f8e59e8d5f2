"""Bench time, and the only place that knows the host's clock."""

from hilbench.clock.host import (
    HostClock,
    InputSource,
    MonotonicHostClock,
    ScaledHostClock,
    Stopwatch,
    wall_time_iso,
    wall_time_ns,
)
from hilbench.clock.interrupts import deferred_interrupts
from hilbench.clock.lateness import LatenessMeter
from hilbench.clock.pace import HEARTBEAT_NS, SLIP_THRESHOLD_NS, PaceListener
from hilbench.clock.scheduler import Entry, EventClass, Scheduler
from hilbench.clock.ticks import NS_PER_MS, NS_PER_S, NS_PER_US, ClockDomain

__all__ = [
    "HEARTBEAT_NS",
    "NS_PER_MS",
    "NS_PER_S",
    "NS_PER_US",
    "SLIP_THRESHOLD_NS",
    "ClockDomain",
    "Entry",
    "EventClass",
    "HostClock",
    "InputSource",
    "LatenessMeter",
    "MonotonicHostClock",
    "PaceListener",
    "ScaledHostClock",
    "Scheduler",
    "Stopwatch",
    "deferred_interrupts",
    "wall_time_iso",
    "wall_time_ns",
]
