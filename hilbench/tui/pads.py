"""Game pads at this machine: found when they are plugged in, read without ever waiting, missed when they are gone."""

from __future__ import annotations

import array
import contextlib
import errno
import fcntl
import os
from pathlib import Path

from hilbench.tui.model.pad import PadState

__all__ = ["LOOK_EVERY_S", "Pads"]

LOOK_EVERY_S = 1.0
"""How often a pad is looked for while there is none (choice)."""
_DEVICES = Path("/dev/input")
_READ_BYTES = 4096
_NAME_BYTES = 64
_JSIOCGNAME = (2 << 30) | (_NAME_BYTES << 16) | (ord("j") << 8) | 0x13
"""``JSIOCGNAME(len)`` of linux/joystick.h: _IOC(_IOC_READ, 'j', 0x13, len)."""


class Pads:
    """The first game pad there is.

    Args:
        folder: where the devices are, as ``js0`` and so on.

    Attributes:
        name: what the pad calls itself; empty while there is none.
        state: where everything on it is.
    """

    def __init__(self, folder: Path = _DEVICES) -> None:
        self.name = ""
        self.state = PadState()
        self._folder = folder
        self._path: Path | None = None
        self._file: int | None = None
        self._look_at_s = 0.0
        self._refused: set[Path] = set()

    def poll(self, now_s: float) -> list[str]:
        """Take what the pad has reported; return what there is to be said of its coming and going.

        Args:
            now_s: any time in seconds that only grows.
        """
        if self._file is not None:
            return self._read()
        if now_s < self._look_at_s:
            return []
        self._look_at_s = now_s + LOOK_EVERY_S
        return self._find()

    def close(self) -> None:
        """Let go of the pad."""
        if self._file is not None:
            os.close(self._file)
        self._file = self._path = None
        self.name, self.state = "", PadState()

    def _find(self) -> list[str]:
        there = set(self._folder.glob("js*")) if self._folder.is_dir() else set()
        self._refused &= there
        said = []
        for path in sorted(there - self._refused):
            try:
                self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
            except OSError as error:
                self._refused.add(path)
                hint = "; members of the group 'input' may" if error.errno == errno.EACCES else ""
                said.append(f"game pad {path} cannot be read: {error.strerror}{hint}")
                continue
            self._path, self.name = path, _name_of(self._file) or path.name
            return [*said, f"game pad: {self.name}. Hold L1 (LB) and drive", *self._read()]
        return said

    def _read(self) -> list[str]:
        assert self._file is not None
        try:
            while data := os.read(self._file, _READ_BYTES):
                self.state.feed(data)
            gone = False
        except BlockingIOError:
            gone = False
        except OSError:
            gone = True
        if not gone and self._path is not None and self._path.exists():
            return []
        name = self.name
        self.close()
        return [f"game pad {name} is gone"]


def _name_of(file: int) -> str:
    name = array.array("B", bytes(_NAME_BYTES))
    with contextlib.suppress(OSError):
        fcntl.ioctl(file, _JSIOCGNAME, name)
    return name.tobytes().partition(b"\0")[0].decode(errors="replace").strip()
