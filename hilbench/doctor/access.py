"""The way to the boards: udev, groups, ports, and programs that reach for them."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

from hilbench.doctor.facts import Facts
from hilbench.doctor.finding import Finding, cross, fine, warning
from hilbench.errors import HilbenchError
from hilbench.files.paths import absolute_path
from hilbench.ports.calibration import Calibration
from hilbench.ports.listing import LINK_FOLDERS, PortInfo
from hilbench.ports.states import PortState, port_states, state_at
from hilbench.ports.usb_devices import kind_of
from hilbench.udev.installing import Checked, check_rules, port_group

__all__ = ["look_at_access"]

_PTS = re.compile(r"/dev/pts/\d+")
_GRABBERS = {
    "ModemManager": "sends AT commands into new ports",
    "brltty": "takes FT232R, CP2102 and CH340 for braille displays",
}

# It takes what udev says of a port for an order at any time; brltty, once it runs, looks for devices by itself.
_ASKS_UDEV = frozenset({"ModemManager"})


def look_at_access(facts: Facts, target: str | None) -> Iterator[Finding]:
    """Give what was found; a target names a port to be looked at beside those that are there."""
    ports = facts.ports()
    rules = check_rules(facts.host)
    yield _rules(rules, ports)
    yield _group(facts, rules)
    yield from _grabbers(facts, rules, ports)
    yield from _stale_links(facts)
    yield from _ports(facts, ports)
    if target is not None:
        yield from _target(facts, target, ports)


def _known(ports: Sequence[PortInfo]) -> bool:
    return any(port.usb is not None and kind_of(port.usb) for port in ports)


def _rules(found: Checked, ports: Sequence[PortInfo]) -> Finding:
    if found.installed is None:
        say = cross if _known(ports) else warning
        return say(
            "udev rules", "are not installed: no access, names or quiet for a board that is plugged in", found.fix
        )
    if found.installed.problems:
        first = found.installed.problems[0]
        return cross("udev rules", f"{found.installed.path}:{first.line}: {first.what}", found.fix)
    if not found.installed.current:
        return warning("udev rules", f"{found.installed.path} is not as this hilbench has it", found.fix)
    return fine("udev rules", f"{found.installed.path}")


def _group(facts: Facts, rules: Checked) -> Finding:
    host = facts.host
    group = (rules.installed.group if rules.installed is not None else None) or port_group(host)
    if host.is_root or group in host.groups:
        return fine("group", "root needs none" if host.is_root else f"{host.user} is in {group}")
    if group in host.groups_of_account:
        fix = "log out and in again, or: newgrp " + group
        return warning("group", f"{host.user} is in {group}, but not in this session", fix)
    fix = f'sudo usermod -aG {group} "$USER", then log out and in again'
    return warning("group", f"{host.user} is not in {group}, which owns serial ports: needed over ssh", fix)


def _grabbers(facts: Facts, rules: Checked, ports: Sequence[PortInfo]) -> Iterator[Finding]:
    """Find programs that take new ports, where no rules keep them off; old rules may not know what is plugged in."""
    running = _programs(facts)
    kept_off = rules.installed is not None and rules.installed.current
    for name, does in _GRABBERS.items():
        if name not in running:
            yield fine(name, "does not run")
        elif kept_off and name in _ASKS_UDEV:
            yield fine(name, "runs, and the udev rules keep it off")
        elif kept_off:
            fix = f"if nobody needs it here: sudo systemctl stop {name}"
            yield warning(name, "runs; the udev rules keep udev from starting it, and do not stop it", fix)
        else:
            say = cross if _known(ports) else warning
            fix = f"{rules.fix}, or without the rules: sudo systemctl stop {name}"
            yield say(name, f"runs, and {does}", fix)


def _programs(facts: Facts) -> set[str]:
    names = set()
    try:
        numbers = [entry.name for entry in facts.host.path("/proc").iterdir() if entry.name.isdigit()]
    except OSError:
        return set()
    for number in numbers:
        names.add((facts.host.text(f"/proc/{number}/comm") or "").strip())
    return names


def _stale_links(facts: Facts) -> Iterator[Finding]:
    """Find names of ports that lead nowhere: of devices that have gone, and of ptys whose bench has ended."""
    of_devices = [link for name in LINK_FOLDERS for link in _stale(facts.host.path(name))]
    here = [(link, end) for link, end in _stale(facts.working_folder) if _PTS.fullmatch(end)]
    for how, links in (("sudo rm", of_devices), ("rm", here)):
        for link, end in links:
            fix = f"{how} {shlex.quote(str(link))}, and plug the board in or start the bench again"
            yield cross("stale name", f"{link} leads to {end}, which is gone", fix)


def _stale(folder: Path) -> list[tuple[Path, str]]:
    """Return the links in a folder that lead nowhere, and where that was."""
    found = []
    with contextlib.suppress(OSError):
        for link in sorted(folder.iterdir()):
            with contextlib.suppress(OSError):  # it goes meanwhile, or is no link
                end = str(link.readlink())
                if not os.path.exists(link):  # noqa: PTH110 - False where one may not look
                    found.append((link, end))
    return found


def _ports(facts: Facts, ports: Sequence[PortInfo]) -> Iterator[Finding]:
    states = port_states(facts.host, ports)
    for state in states:
        # One that is soldered in is there whether somebody needs it or not, and who holds a port may be right to.
        needed = state.port.usb is not None and not state.holders.programs
        yield from _port(state, facts.calibration(state.port.device, ports), needed=needed)
    if not states:
        yield fine("ports", "none is here")


def _port(state: PortState, calibration: Calibration | None, *, needed: bool) -> Iterator[Finding]:
    for advice in state.advice:
        yield (cross if advice.shuts and needed else warning)(state.port.device, advice.what, advice.fix)
    if not state.advice:
        kept = "how exact it is was not measured"
        if calibration is not None:
            kept = f"adds {calibration.uncertainty_s * 1000:.2f} ms to times, measured {calibration.measured_at}"
        yield fine(state.port.device, f"may be used, and is free ({state.owner}); {kept}")


def _target(facts: Facts, target: str, ports: Sequence[PortInfo]) -> Iterator[Finding]:
    """Look at the port that somebody means to use."""
    from hilbench.links.serial_target import located, parse_serial_target

    try:
        meant = located(parse_serial_target(target), lambda: ports)
        url = str(absolute_path(meant.url)) if meant.is_device else meant.url
    except HilbenchError as error:
        yield cross(target, error.message, error.hint or "see hilbench ports")
        return
    if not meant.is_device:
        yield fine(target, "is not a port of this machine; it was not looked at")
        return
    if not facts.host.path(url).exists():
        there = ", ".join(port.device for port in ports)
        fix = f"use one of those that are there: {there}" if there else "plug it in; there is no port here now"
        yield cross(target, "there is no such port", fix)
        return
    yield from _port(state_at(facts.host, url, ports), facts.calibration(url, ports), needed=True)
