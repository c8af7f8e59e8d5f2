"""Who has a serial port open, found without opening it: to open a port may reset the board behind it.

A program that has it open shows among its descriptors (``/proc/PID/fd``, which only root sees of other users); one that
locked it shows in ``/proc/locks``, which everybody sees (proc(5)); and old terminal programs leave a lock file
``LCK..NAME`` with their number in it (Filesystem Hierarchy Standard 3.0, 5.9).

Whoever serves a pseudo-terminal often has it open, too, beside its master, so that it does not hang up with its last
client. That is what is behind the port and nobody who has it, unless it locked it.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from hilbench.files.host import Host
from hilbench.files.names import printable

__all__ = ["Holder", "Holders", "holders_of"]

_LOCK_FOLDERS = ("/run/lock", "/var/lock")
# A line of /proc/locks: number, kind, mode, access, process, device and inode in hex and decimal, range.
_LOCK = re.compile(r"\d+:\s+FLOCK\s+\S+\s+\S+\s+(?P<process>-?\d+)\s+(?P<major>\w+):(?P<minor>\w+):(?P<inode>\d+)\s")
_PROCESS = re.compile(r"\s*(?P<number>[0-9]{1,9})(\s|$)")

_PTY = re.compile(r"/dev/pts/(?P<number>\d+)")
_MASTERS = ("/dev/ptmx", "/dev/pts/ptmx")
_INDEX = re.compile(r"^tty-index:\s*(\d+)$", re.MULTILINE)


@dataclass(frozen=True, slots=True, kw_only=True, order=True)
class Holder:
    """A program that has a port.

    Attributes:
        process: its number; 0 for one that cannot be seen from here, such as one outside a container.
        name: what it is called; empty if that cannot be seen.
    """

    process: int
    name: str

    def __str__(self) -> str:
        return (
            f"{self.name or 'a program'} ({self.process})"
            if self.process
            else "a program that cannot be seen from here"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Holders:
    """Who has a port.

    Attributes:
        programs: those that have it, by number.
        stale_lock: a lock file whose program is gone; None without.
        hidden: whether there are programs of other users, whose descriptors cannot be seen.
    """

    programs: tuple[Holder, ...]
    stale_lock: str | None = None
    hidden: bool = False


def holders_of(host: Host, device: str) -> Holders:
    """Return who has a port; `device` is its own path and no link."""
    numbers, hidden = _with_descriptor(host, device)
    numbers |= _with_lock(host, device)
    stale = None
    for path, process in _lock_files(host, device):
        if process is not None and host.path(f"/proc/{process}").exists():
            numbers.add(process)
        else:
            stale = path
    programs = sorted(Holder(process=number, name=_name(host, number)) for number in numbers)
    return Holders(programs=tuple(programs), stale_lock=stale, hidden=hidden)


def _with_descriptor(host: Host, device: str) -> tuple[set[int], bool]:
    found, hidden = set(), False
    for process in _processes(host):
        try:
            links = list((process / "fd").iterdir())
            if any(_leads_to(link, device) for link in links) and not _serves(links, device):
                found.add(int(process.name))
        except PermissionError:
            hidden = True
        except OSError:  # it has ended
            continue
    return found, hidden


def _processes(host: Host) -> Iterator[Path]:
    try:
        yield from (entry for entry in host.path("/proc").iterdir() if entry.name.isdigit())
    except OSError:
        return


def _leads_to(link: Path, device: str) -> bool:
    try:
        return str(link.readlink()) == device
    except OSError:
        return False


def _serves(links: Iterable[Path], device: str) -> bool:
    """Say whether the master of a pseudo-terminal is among some descriptors; their ``fdinfo`` has its number."""
    pty = _PTY.fullmatch(device)
    if pty is None:
        return False
    masters = [link for link in links if any(_leads_to(link, name) for name in _MASTERS)]
    return any(pty["number"] in _INDEX.findall(_about(link)) for link in masters)


def _about(link: Path) -> str:
    try:
        return (link.parent.with_name("fdinfo") / link.name).read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""


def _with_lock(host: Host, device: str) -> set[int]:
    try:
        node = host.path(device).stat()
    except OSError:
        return set()
    wanted = (os.major(node.st_dev), os.minor(node.st_dev), node.st_ino)
    found = (_LOCK.match(line.strip()) for line in (host.text("/proc/locks") or "").splitlines())
    return {
        max(int(lock["process"]), 0)
        for lock in found
        if lock and (int(lock["major"], 16), int(lock["minor"], 16), int(lock["inode"])) == wanted
    }


def _lock_files(host: Host, device: str) -> Iterator[tuple[str, int | None]]:
    seen = set()
    for folder in _LOCK_FOLDERS:
        path = f"{folder}/LCK..{Path(device).name}"
        text = host.text(path)
        real = os.path.realpath(host.path(path))
        if text is not None and real not in seen:
            seen.add(real)
            number = _PROCESS.match(text)
            yield path, int(number["number"]) if number else None


def _name(host: Host, process: int) -> str:
    return printable((host.text(f"/proc/{process}/comm") or "").strip())
