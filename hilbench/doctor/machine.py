"""The machine: pseudo-terminals, descriptors, clock, how punctual it is, and where files go."""

from __future__ import annotations

from collections.abc import Iterator

from hilbench.bench import LOCKED_FLOOR_S
from hilbench.clock import NS_PER_MS, NS_PER_S, LatenessMeter
from hilbench.doctor.facts import Facts
from hilbench.doctor.finding import Finding, cross, fine, warning

__all__ = ["look_at_machine"]

_PTYS_LEFT = 16
_FILES = 256
_PTY_MAX, _PTY_NOW = "/proc/sys/kernel/pty/max", "/proc/sys/kernel/pty/nr"
_CLOCK = "/sys/devices/system/clocksource/clocksource0"
# Sources that are read in the process itself take some 25 ns, these a call into the kernel and a slow device.
_SLOW_CLOCKS = frozenset({"hpet", "acpi_pm", "jiffies", "refined-jiffies", "pit"})
_GOVERNOR = "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"


def look_at_machine(facts: Facts) -> Iterator[Finding]:
    """Give what was found."""
    yield _ptys(facts)
    yield _files(facts)
    yield _clock(facts)
    yield _jitter(facts)
    yield from _folders(facts)


def _ptys(facts: Facts) -> Finding:
    try:
        facts.open_pty()
    except OSError as error:
        fix = f"raise the limit ({_PTY_NOW} are in use): sudo sysctl kernel.pty.max=4096, or without /dev/pts: "
        fix += "sudo mount -t devpts devpts /dev/pts"
        return cross("pseudo-terminals", f"none can be opened: {error.strerror or error}", fix)
    most, now = _number(facts, _PTY_MAX), _number(facts, _PTY_NOW)
    if most is None or now is None:
        return fine("pseudo-terminals", "can be opened")
    if most - now < _PTYS_LEFT:
        fix = f"sudo sysctl kernel.pty.max={max(4096, 2 * most)}, or close terminals"
        return warning("pseudo-terminals", f"{now} of {most} are in use", fix)
    return fine("pseudo-terminals", f"{now} of {most} in use")


def _files(facts: Facts) -> Finding:
    if facts.file_limit < _FILES:
        return warning("descriptors", f"a process may have {facts.file_limit}, few for many boards", "ulimit -n 1024")
    return fine("descriptors", f"a process may have {facts.file_limit}")


def _clock(facts: Facts) -> Finding:
    source = (facts.host.text(f"{_CLOCK}/current_clocksource") or "").strip()
    if source in _SLOW_CLOCKS:
        there = (facts.host.text(f"{_CLOCK}/available_clocksource") or "").split()
        better = next((one for one in there if one not in _SLOW_CLOCKS), None)
        fix = (
            f"echo {better} | sudo tee {_CLOCK}/current_clocksource"
            if better
            else "on a virtual machine, ask for its TSC"
        )
        return warning("clock", f"the kernel reads its time from {source}, which is slow", fix)
    return fine("clock", source or "of unknown source")


def _jitter(facts: Facts) -> Finding:
    meter = LatenessMeter()
    for late_ns in facts.lateness_ns():
        meter.record(late_ns, 0)
    p50, p99, most = (ns / NS_PER_MS for ns in (meter.quantile_ns(0.5), meter.quantile_ns(0.99), meter.max_ns))
    what = f"wakes up {p50:.2f} ms late (half), {p99:.2f} ms (99 %), {most:.2f} ms (the worst)"
    if meter.quantile_ns(0.99) <= LOCKED_FLOOR_S * NS_PER_S:
        return fine("punctuality", what)
    governor = (facts.host.text(_GOVERNOR) or "").strip()
    fix = "close other programs; every verdict on a time in real time is as much less certain"
    if governor not in {"", "performance"}:
        fix += f"; the processor saves power ({governor}): sudo cpupower frequency-set -g performance"
    return warning("punctuality", what, fix)


def _folders(facts: Facts) -> Iterator[Finding]:
    temporary = facts.write_error(facts.temporary_folder)
    if temporary:
        yield cross("files", f"nothing can be written: {temporary}", "make room there, or: export TMPDIR=DIR")
    state = _why_nothing_is_kept(facts)
    if state:
        fix = f"give {facts.host.user} the folder, or: " if facts.state_folder is not None else ""
        yield warning("files", f"calibrations cannot be kept: {state}", f"{fix}export XDG_STATE_HOME=DIR")
    if not (temporary or state):
        yield fine("files", f"{facts.temporary_folder} and {facts.state_folder} can be written")


def _why_nothing_is_kept(facts: Facts) -> str | None:
    if facts.state_folder is None:
        return f"{facts.host.user} has no home"
    return facts.write_error(facts.state_folder)


def _number(facts: Facts, path: str) -> int | None:
    text = (facts.host.text(path) or "").strip()
    return int(text) if text.isdecimal() else None
