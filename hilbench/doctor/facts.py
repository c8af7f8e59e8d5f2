"""What the doctor asks, each in one place: tests answer for a machine that does not exist."""

from __future__ import annotations

import contextlib
import importlib.metadata
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hilbench.cli.siblings import check_siblings
from hilbench.clock import NS_PER_MS, MonotonicHostClock
from hilbench.errors import HilbenchError, UnavailableError
from hilbench.files.host import Host, this_host
from hilbench.ports.calibration import Calibration, calibration_of, state_folder
from hilbench.ports.listing import PortEnumerator, PortInfo, list_ports

__all__ = ["Facts", "this_machine"]

_WAKE_UPS = 100
_PERIOD_NS = 2 * NS_PER_MS
_PATIENCE_S = 60


def _requirements() -> Sequence[str] | None:
    try:
        return importlib.metadata.requires("hilbench") or ()
    except importlib.metadata.PackageNotFoundError:
        return None


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None


def _import_error(module: str) -> str | None:
    """Import a module in a process of its own; return the last line of what it said if that went wrong."""
    program = [sys.executable, "-c", f"import {module}"]
    try:
        done = subprocess.run(program, capture_output=True, text=True, timeout=_PATIENCE_S, check=False)
    except (OSError, subprocess.SubprocessError) as error:
        return str(error)
    said = done.stderr.strip().splitlines()
    return None if done.returncode == 0 else (said[-1] if said else f"exit code {done.returncode}")


def _intruder() -> HilbenchError | None:
    try:
        check_siblings()
    except HilbenchError as error:
        return error
    return None


def _core() -> str:
    try:
        from targets.mcu.core.library import about
        from targets.mcu.errors import EngineError
    except ImportError as error:  # another package is called `targets`
        raise UnavailableError(f"cannot be imported: {error}", hint="install hilbench again") from error
    try:
        core = about()
    except EngineError as error:
        raise UnavailableError(str(error), where=error.where or None, hint=error.hint) from error
    return f"{core.path}, by {core.compiler}, sources {core.digest[:12]}"


def _open_pty() -> None:
    for descriptor in os.openpty():
        os.close(descriptor)


def _lateness_ns() -> Sequence[int]:
    """Return how late each of some wake-ups was."""
    clock = MonotonicHostClock()
    found = []
    try:
        due_ns = clock.monotonic_ns()
        for _ in range(_WAKE_UPS):
            due_ns = max(due_ns + _PERIOD_NS, clock.monotonic_ns())
            clock.wait_until(due_ns)
            found.append(max(0, clock.monotonic_ns() - due_ns))
    finally:
        clock.close()
    return found


def _write_error(folder: Path) -> str | None:
    """Say why no file can be written into a folder, or into the first there is above it."""
    try:
        while not folder.exists() and folder != folder.parent:
            folder = folder.parent
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(b"?" * 4096)
            file.flush()
    except OSError as error:
        return f"{folder}: {error.strerror or error}"
    return None


def _working_folder() -> Path:
    with contextlib.suppress(OSError):  # it has been removed
        return Path.cwd()
    return Path("/")


def _temporary_folder() -> Path:
    with contextlib.suppress(OSError):
        return Path(tempfile.gettempdir())
    return Path("/tmp")  # noqa: S108 - to say that nothing can be written there


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """A machine, a Python, and the ports.

    Attributes:
        host: files, programs, the user.
        ports: which ports there are.
        python: version of the interpreter.
        executable: its path.
        requirements: what hilbench says it needs; None if it is not installed as a distribution.
        version_of: which version of a distribution is installed, if it is.
        import_error: why a module cannot be imported, if it cannot.
        core: loads the library of the emulated CPU, compiled where need be, and says what it is; else UnavailableError.
        distributions: which distributions have brought each top-level package.
        intruder: what stands in the place of a package of ours, if something does.
        working_folder: where we are.
        open_pty: opens a pseudo-terminal and closes it; OSError if that is not possible.
        file_limit: how many descriptors a process may have.
        lateness_ns: measures how late wake-ups are, in ns.
        state_folder: where calibrations are kept; None if there is no home for it.
        temporary_folder: where files of a run are made.
        write_error: why no file can be written into a folder, if none can.
        calibration: what is kept of a port, if something is.
    """

    host: Host = field(default_factory=this_host)
    ports: PortEnumerator = list_ports
    python: tuple[int, int, int] = sys.version_info[:3]
    executable: str = sys.executable
    requirements: Sequence[str] | None = field(default_factory=_requirements)
    version_of: Callable[[str], str | None] = _version
    import_error: Callable[[str], str | None] = _import_error
    core: Callable[[], str] = _core
    distributions: Mapping[str, Sequence[str]] = field(default_factory=importlib.metadata.packages_distributions)
    intruder: HilbenchError | None = field(default_factory=_intruder)
    working_folder: Path = field(default_factory=_working_folder)
    open_pty: Callable[[], None] = _open_pty
    file_limit: int = field(default_factory=lambda: resource.getrlimit(resource.RLIMIT_NOFILE)[0])
    lateness_ns: Callable[[], Sequence[int]] = _lateness_ns
    state_folder: Path | None = field(default_factory=state_folder)
    temporary_folder: Path = field(default_factory=_temporary_folder)
    write_error: Callable[[Path], str | None] = _write_error
    calibration: Callable[[str, Sequence[PortInfo]], Calibration | None] = calibration_of


def this_machine() -> Facts:
    """Return the machine we are on."""
    return Facts()
