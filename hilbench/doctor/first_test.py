"""`hilbench init --protocol`: a first test for a board at a serial port, which pytest finds again wherever it is."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from hilbench.errors import UnavailableError, UsageError
from hilbench.files.names import escaped
from hilbench.files.new_files import Written, write_new
from hilbench.files.paths import absolute_path
from hilbench.links.serial_target import LineSettings, SerialTarget, parse_serial_target
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.ports.choice import PortChoice, choose_port, parse_port_choice, tells_apart
from hilbench.ports.listing import PortEnumerator, PortInfo, list_ports

__all__ = ["init_port"]

TEST_NAME = "test_board.py"
PYTEST_NAME = "pytest.ini"


_INI = """\
[pytest]
addopts = {words}
"""


def init_port(
    protocol: ProtocolPlugin, port: str, baud: int | None, folder: Path, *, ports: PortEnumerator = list_ports
) -> Written:
    """Write a test, and have pytest know the board.

    Args:
        protocol: what it speaks.
        port: as after ``--target``: its path, or what is plugged in there (``serial=...``), with or without ``serial:``
            and a rate; empty for the only one with something plugged in.
        baud: rate of the line, bit/s; None for that of the port, or the usual one of the protocol.
        folder: where to write; it must exist.
        ports: says which ports there are.

    Raises:
        UsageError: several ports are meant, or none can be, or two rates; or a file is there already. Then nothing is
            written.
        UnavailableError: nothing is plugged in, or nothing that is what was asked for.
    """
    wanted = protocol.first_test
    if wanted is None:
        raise UsageError("has no first test to be written", where=f"--protocol {protocol.name}")
    there = ports()
    if port:
        meant = _meant(port, baud, protocol.baud)
        found = _find(meant, there)
    else:
        found = _only_one(there)
        meant = SerialTarget(url=found.device, baud=baud or protocol.baud)
    target = f"serial:{_named(found, there)}@{meant.baud}{_how(meant.settings)}"
    options = ["-p", "hilbench.pytest_plugin", "--hil-bench", wanted.bench, "--hil-target", target]
    texts = {folder / TEST_NAME: wanted.text.format(target=escaped(target).replace('"', "'"))}
    ini, notes = folder / PYTEST_NAME, [f"the board is {_about(found)}"]
    if ini.exists():
        notes.append(f"{ini} is there already and stays as it is; it needs: addopts = {shlex.join(options)}")
    else:
        texts[ini] = _INI.format(words=shlex.join(options))
    return Written(files=write_new(texts), notes=tuple(notes))


def _meant(port: str, baud: int | None, usual: int) -> SerialTarget:
    """Return what a port is meant by: pytest may be started in another folder, so a path begins at the root."""
    meant = parse_serial_target(port, baud or usual)
    if baud is not None and meant.baud != baud:
        raise UsageError(f"the port has {meant.baud} baud", where=f"--baud {baud}", hint="say one rate")
    is_path = meant.is_device and parse_port_choice(meant.url) is None
    return replace(meant, url=str(absolute_path(meant.url))) if is_path else meant


def _how(settings: LineSettings) -> str:
    """Return how a port is opened, as behind its rate; empty if as usual."""
    lines = {"dtr": settings.dtr, "rts": settings.rts}
    words = [f"{name}={'on' if level else 'off'}" for name, level in lines.items() if level is not None]
    words += [f"parity={settings.parity}"] if settings.parity != "N" else []
    words += [f"stop={settings.stop_bits}"] if settings.stop_bits != 1 else []
    return "".join(f",{word}" for word in words)


def _find(meant: SerialTarget, there: Sequence[PortInfo]) -> PortInfo:
    choice = parse_port_choice(meant.url)
    if choice is not None:
        return choose_port(choice, there)
    known = next((one for one in there if meant.url in {one.device, *one.links}), None)
    return known or PortInfo(device=meant.url)


def _only_one(there: Sequence[PortInfo]) -> PortInfo:
    plugged = [one for one in there if one.usb is not None]
    if not plugged:
        raise UnavailableError(
            "nothing is plugged in at a serial port", where="init", hint="plug a board in, or name it: --port PATH"
        )
    if len(plugged) > 1:
        names = ", ".join(one.device for one in plugged)
        raise UsageError(f"several boards are plugged in: {names}", where="init", hint="choose one with --port")
    return plugged[0]


def _named(port: PortInfo, there: Sequence[PortInfo]) -> str:
    """Return the fewest words that mean this port and no other of those that are there; its path if there are none."""
    usb = port.usb
    if usb is None:
        return port.device
    number = usb.serial_number
    words = [("usb", usb.ids), ("serial", number) if number and tells_apart(number) else ("location", usb.location)]
    for more in (None, ("interface", str(usb.interface)), ("location", usb.location)):
        words += [more] if more is not None and more not in words else []
        choice = PortChoice(tuple(words))
        if sum(choice.fits(one) for one in there) <= 1:
            return str(choice)
    return port.device


def _about(port: PortInfo) -> str:
    usb = port.usb
    if usb is None:
        what = "no USB port" if "://" in port.device or Path(port.device).exists() else "not there now"
        return f"at {port.device}, which is {what}: it is known by this name alone"
    name = " ".join(part for part in (usb.manufacturer, usb.product) if part) or usb.ids
    return f"{escaped(name)}, at {port.device} now"
