"""What hilbench asks the machine it runs on, in one place: files, programs, who the user is.

Tests hand in a machine of their own making.
"""

from __future__ import annotations

import contextlib
import grp
import os
import pwd
import shutil
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

__all__ = ["Host", "Ran", "this_host"]

_PATIENCE_S = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Ran:
    """What a program did.

    Attributes:
        code: its exit code.
        output: what it printed, on both streams.
    """

    code: int
    output: str


def _run(command: Sequence[str]) -> Ran | None:
    """Run a program to its end; None if that is not possible."""
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=_PATIENCE_S,
            check=False, text=True, errors="replace",
        )  # fmt: skip
    except (OSError, subprocess.SubprocessError):
        return None
    return Ran(code=done.returncode, output=done.stdout)


def _may_use(path: Path) -> bool:
    """Say whether this process may read and write a file, by whatever gives it the right: owner, group, list."""
    return os.access(path, os.R_OK | os.W_OK, effective_ids=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Host:
    """A machine and the user on it.

    Attributes:
        root: where ``dev``, ``proc``, ``sys``, ``etc`` and ``run`` are.
        user: name of the user.
        user_id: number of the user this process acts as; 0 is root.
        groups: names of the groups of this process.
        groups_of_account: names of the groups the account is in; new ones count after the next login.
        which: finds a program.
        run: runs one to its end; None if that is not possible.
        may_use: says whether this process may read and write a file.
    """

    root: Path = Path("/")
    user: str = "root"
    user_id: int = 0
    groups: frozenset[str] = frozenset()
    groups_of_account: frozenset[str] = frozenset()
    which: Callable[[str], str | None] = field(default=shutil.which)
    run: Callable[[Sequence[str]], Ran | None] = field(default=_run)
    may_use: Callable[[Path], bool] = field(default=_may_use)

    @property
    def is_root(self) -> bool:
        """Whether permissions do not matter."""
        return self.user_id == 0

    def path(self, name: str) -> Path:
        """Return a path of this machine, such as that of ``/dev/ttyUSB0``."""
        return self.root / name.lstrip("/")

    def text(self, name: str) -> str | None:
        """Return what is in a file; None if it cannot be read."""
        try:
            return self.path(name).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return None

    def has_group(self, name: str) -> bool:
        """Say whether there is a group of that name."""
        lines = (self.text("/etc/group") or "").splitlines()
        return any(line.partition(":")[0] == name for line in lines)

    def group_name(self, number: int) -> str:
        """Return the name of a group; its number where it has none."""
        for line in (self.text("/etc/group") or "").splitlines():
            fields = line.split(":")
            if fields[2:3] == [str(number)]:
                return fields[0]
        return str(number)


def this_host() -> Host:
    """Return the machine we are on."""
    user = str(os.getuid())
    with contextlib.suppress(KeyError):
        user = pwd.getpwuid(os.getuid()).pw_name
    return Host(
        user=user,
        user_id=os.geteuid(),
        groups=frozenset(_names({os.getegid(), *os.getgroups()})),
        groups_of_account=frozenset(entry.gr_name for entry in grp.getgrall() if user in entry.gr_mem),
    )


def _names(numbers: set[int]) -> list[str]:
    names = []
    for number in numbers:
        with contextlib.suppress(KeyError):
            names.append(grp.getgrgid(number).gr_name)
    return names
