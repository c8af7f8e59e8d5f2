"""How a port stands: what is plugged in, who has it, whether we may use it, and what to do if not."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from hilbench.files.host import Host
from hilbench.files.paths import absolute_path
from hilbench.ports.choice import tells_apart
from hilbench.ports.holders import Holders, holders_of
from hilbench.ports.listing import PortInfo
from hilbench.ports.usb_devices import chip_of, kind_of, probable_board
from hilbench.udev.installing import INSTALL_BY, installed_rules, port_group

__all__ = [
    "BEST_LATENCY_MS",
    "Advice",
    "PortState",
    "advice_on_access",
    "as_data",
    "as_text",
    "port_states",
    "state_at",
]

BEST_LATENCY_MS = 1


@dataclass(frozen=True, slots=True)
class Advice:
    """Something in the way at a port.

    Attributes:
        what: what is seen, without a full stop.
        fix: what to do.
        shuts: whether the port cannot be used as long as it is so.
    """

    what: str
    fix: str
    shuts: bool = True

    def __str__(self) -> str:
        return f"{self.what}: {self.fix}"


@dataclass(frozen=True, slots=True, kw_only=True)
class PortState:
    """One port.

    Attributes:
        port: what is plugged in.
        target: how it is best named on a command line.
        permitted: whether we may use it.
        owner: its group and mode, such as ``dialout 0660``; empty if it has no node.
        holders: who has it.
        advice: what is in the way, and what to do about it.
    """

    port: PortInfo
    target: str
    permitted: bool
    owner: str
    holders: Holders
    advice: tuple[Advice, ...]


def port_states(host: Host, ports: Sequence[PortInfo]) -> list[PortState]:
    """Return how each port stands."""
    return [_state(host, port, ports) for port in ports]


def state_at(host: Host, path: str, ports: Sequence[PortInfo]) -> PortState:
    """Return how the port stands that a path or a link leads to, whether it is one of those there are or not.

    Raises:
        UnavailableError: the path begins in the working folder, and that has been removed.
    """
    real, root = Path(os.path.realpath(host.path(str(absolute_path(path))))), host.root.resolve()
    device = f"/{real.relative_to(root)}" if real.is_relative_to(root) else str(real)
    port = next((one for one in ports if one.device == device), PortInfo(device=device))
    return _state(host, port, ports)


def as_data(states: Sequence[PortState]) -> list[dict[str, object]]:
    """Return them as plain data."""
    return [_data(state) for state in states]


def as_text(states: Sequence[PortState]) -> str:
    """Return them as lines for a person, a paragraph each."""
    return "\n\n".join("\n".join(_lines(state)) for state in states)


def _state(host: Host, port: PortInfo, ports: Sequence[PortInfo]) -> PortState:
    node = host.path(port.device)
    owner, permitted = "", False
    with contextlib.suppress(OSError):  # there is none
        facts = node.stat()
        owner = f"{host.group_name(facts.st_gid)} {facts.st_mode & 0o7777:04o}"
        permitted = host.may_use(node)
    holders = holders_of(host, port.device)
    state = PortState(
        port=port, target=_target(port, ports), permitted=permitted, owner=owner, holders=holders, advice=()
    )
    advice = (
        *([] if permitted else [advice_on_access(host, state)]),
        *(Advice("it is in use", f"stop {holder}") for holder in holders.programs),
        *_on_locks(state),
        *_on_latency(host, state),
    )
    return replace(state, advice=advice)


def advice_on_access(host: Host, state: PortState) -> Advice:
    """Return what to do at a port that may not be used."""
    if not state.owner:
        device = state.port.device
        return Advice(f"there is no {device}", f"in a container, start it with --device {device}")
    group = state.owner.split()[0]
    if group in host.groups_of_account and group not in host.groups:
        return Advice("no access yet", f"you came into the group {group} after you logged in; log out and in again")
    if _rules_know(state.port) and installed_rules(host) is None:
        return Advice("no access", f"{INSTALL_BY}, then plug it in again")
    return Advice("no access", _by_group(host, state))


def _by_group(host: Host, state: PortState) -> str:
    """Return how a port gets a group that may use it, and its user into that group; that of root is for root."""
    device, (group, mode) = state.port.device, state.owner.split()
    wanted = group if group != "root" else port_group(host)
    steps = []
    if wanted not in host.groups:
        steps.append(f'sudo usermod -aG {wanted} "$USER", then log out and in again')
    if wanted != group:
        steps.append(f"sudo chgrp {wanted} {device}")
    if int(mode, 8) & 0o060 != 0o060:
        steps.append(f"sudo chmod g+rw {device}")
    return "; ".join(steps) or f"something beside group and mode keeps you out: getfacl {device}"


def _on_locks(state: PortState) -> list[Advice]:
    if state.holders.stale_lock is None:
        return []
    return [Advice("a program that has ended left a lock file", f"sudo rm {state.holders.stale_lock}", shuts=False)]


def _on_latency(host: Host, state: PortState) -> list[Advice]:
    latency_ms = state.port.latency_ms
    if latency_ms is None or latency_ms <= BEST_LATENCY_MS:
        return []
    how = f"echo {BEST_LATENCY_MS} | sudo tee {state.port.sysfs}/latency_timer"
    fix = how if installed_rules(host) is not None else INSTALL_BY
    return [Advice(f"what comes in waits up to {latency_ms} ms", fix, shuts=False)]


def _rules_know(port: PortInfo) -> bool:
    return port.usb is not None and kind_of(port.usb) is not None


def _target(port: PortInfo, ports: Sequence[PortInfo]) -> str:
    """Return the most lasting words that mean this port and no other."""
    usb = port.usb
    if usb is None:
        return f"serial:{port.device}"
    identities = [other.usb for other in ports if other.usb is not None]
    if tells_apart(usb.serial_number):
        with_number = [other for other in identities if other.serial_number == usb.serial_number]
        if len(with_number) == 1:
            return f"serial:serial={usb.serial_number}"
        if sum(other.interface == usb.interface for other in with_number) == 1:
            return f"serial:serial={usb.serial_number},interface={usb.interface}"
    at_place = [other for other in identities if other.location == usb.location]
    more = f",interface={usb.interface}" if len(at_place) > 1 else ""
    return f"serial:location={usb.location}{more}"


def _data(state: PortState) -> dict[str, object]:
    port, usb = state.port, state.port.usb
    return {
        "device": port.device,
        "target": state.target,
        "usb": None if usb is None else {
            "id": usb.ids,
            "serial_number": usb.serial_number,
            "location": usb.location,
            "interface": usb.interface,
            "manufacturer": usb.manufacturer,
            "product": usb.product,
        },
        "chip": chip_of(usb) if usb else None,
        "probable_board": (probable_board(usb) or None) if usb else None,
        "driver": port.driver,
        "links": list(port.links),
        "owner": state.owner or None,
        "permitted": state.permitted,
        "held_by": [{"process": one.process, "name": one.name} for one in state.holders.programs],
        "stale_lock": state.holders.stale_lock,
        "others_hidden": state.holders.hidden,
        "latency_ms": state.port.latency_ms,
        "advice": [{"what": advice.what, "fix": advice.fix} for advice in state.advice],
    }  # fmt: skip


def _lines(state: PortState) -> list[str]:
    port, usb = state.port, state.port.usb
    lines = [f"{port.device}  {_what(port)}"]
    if usb is not None:
        number = f"serial number {usb.serial_number}" if usb.serial_number else "no serial number"
        interface = f", interface {usb.interface}" if usb.interface else ""
        lines.append(f"  plugged in   {usb.ids} at {usb.location}{interface}, {number}")
        if board := probable_board(usb):
            lines.append(f"  probably     {board}")
    lines.append(f"  target       {state.target}")
    lines += [f"  also         {link}" for link in port.links]
    lines.append(f"  access       {'yes' if state.permitted else 'no'}{f' ({state.owner})' if state.owner else ''}")
    lines.append(f"  in use       {_use(state.holders)}")
    lines += [f"  do           {advice}" for advice in state.advice]
    return lines


def _what(port: PortInfo) -> str:
    driver = f" ({port.driver})" if port.driver else ""
    return f"{chip_of(port.usb)}{driver}" if port.usb else f"soldered in{driver}"


def _use(holders: Holders) -> str:
    if holders.programs:
        return ", ".join(str(one) for one in holders.programs)
    return "not by a program that can be seen from here; root sees all" if holders.hidden else "no"
