"""Compiles the library: ``python -m targets.mcu.core.build``.

The compiler is ``$CC`` or ``cc``, else that of the package ziglang, whichever first makes a shared library. Processes
that start together compile it once where the file system has locks; where it has none, the last to end replaces what
the others made, which is the same.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import importlib.util
import os
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from targets.mcu.core.sources import COMPILE, LINK, SOURCES, current, digest_of, places
from targets.mcu.errors import EngineError

__all__ = ["build", "compile_library", "find_compiler", "main", "some_compiler", "zig_for"]

_OLDEST_GLIBC = "2.17"
"""As manylinux2014 has it."""

_PROBE = "#include <math.h>\n#include <stdint.h>\n#include <string.h>\nint32_t hil_probe(void) { return 0; }\n"
_NO_COMPILER = f"sudo apt install gcc libc6-dev, or: {sys.executable} -m pip install ziglang"
_UNAVAILABLE = 3  # as hilbench's exit code for what a bench cannot do without


def build() -> Path:
    """Return the library of the sources; compile it where it is missing.

    Raises:
        EngineError: no compiler, no folder that can be written, or the compiler refuses a source.
    """
    digest = digest_of()
    candidates = places(digest)
    compiler = None
    refusals = []
    for place in candidates:
        try:
            with _locked(place.parent):
                found = current(digest, candidates)
                if found is not None:
                    return found
                if compiler is None:
                    compiler = some_compiler()
                    sys.stderr.write("hilbench: compiling the emulated CPU ...\n")
                compile_library(place, compiler)
                return place
        except OSError as error:
            refusals.append(f"{place.parent}: {error.strerror or error}")
    hint = f"as its owner: {sys.executable} -m targets.mcu.core.build"
    raise EngineError(
        "the emulated CPU is not compiled, and no folder for it can be written", where=refusals[0], hint=hint
    )


def some_compiler() -> Sequence[str]:
    """Return what `find_compiler` finds.

    Raises:
        EngineError: it finds none.
    """
    compiler = find_compiler()
    if compiler is None:
        raise EngineError("the emulated CPU is not compiled, and there is no C compiler", hint=_NO_COMPILER)
    return compiler


def find_compiler() -> Sequence[str] | None:
    """Return the command of a compiler that makes shared libraries for this machine, or None."""
    for command in (_words(os.environ.get("CC", "")), ["cc"]):
        if command and _makes_libraries(command):
            return command
    return zig_for(os.uname().machine) if importlib.util.find_spec("ziglang") else None


def zig_for(machine: str) -> Sequence[str]:
    """Return the command of ziglang's compiler for Linux on a machine, such as ``aarch64``, with glibc 2.17 or newer.

    It brings the headers and stubs of that glibc. Its run-time library, whose division of 128-bit integers and the like
    nothing here needs, is left out: to compile that takes half a minute. Nor does it add checks, as with -O0.
    """
    target = f"{machine}-linux-gnu.{_OLDEST_GLIBC}"
    return [sys.executable, "-m", "ziglang", "cc", "-target", target, "-nostdlib", "-lc", "-fno-sanitize=undefined"]


def _words(command: str) -> list[str]:
    try:
        return shlex.split(command)
    except ValueError:  # a quotation without an end
        return [command]


def _makes_libraries(command: Sequence[str]) -> bool:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "probe.c")
        source.write_text(_PROBE)
        arguments = [*command, *COMPILE, *LINK, str(source), "-o", str(source.with_suffix(".so"))]
        try:
            return subprocess.run(arguments, capture_output=True, check=False).returncode == 0
        except OSError:
            return False


def compile_library(library: Path, compiler: Sequence[str], flags: Sequence[str] = (), sources: Path = SOURCES) -> None:
    """Compile all sources, as many at a time as there are processors, and put the library in place at once.

    Args:
        library: the file to make or replace; its folder must exist.
        compiler: the command.
        flags: further ones, for compiling and linking.
        sources: the folder with the C files.

    Raises:
        EngineError: the compiler refuses a source.
        OSError: the folder cannot be written.
    """
    files = sorted(sources.glob("*.c"))
    with tempfile.TemporaryDirectory(prefix=".build-", dir=library.parent) as folder:
        made = Path(folder, library.name)
        objects = [Path(folder, f"{file.stem}.o") for file in files]
        own = [*COMPILE, *flags, f'-DHIL_SOURCES_DIGEST="{digest_of(sources)}"', "-c"]
        jobs = [[*compiler, *own, file.name, "-o", str(to)] for file, to in zip(files, objects, strict=True)]
        _run_all(jobs, sources, folder)
        _run_all([[*compiler, *flags, *LINK, *map(str, objects), "-o", str(made)]], sources, folder)
        made.replace(library)


def _run_all(jobs: Sequence[Sequence[str]], sources: Path, folder: str) -> None:
    """Run commands in the folder of the sources, which gives messages and assertions short names."""
    caches = {name: os.environ.get(name, folder) for name in ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR")}
    waiting, running = list(jobs), list[subprocess.Popen[str]]()
    while waiting or running:
        while waiting and len(running) < (os.cpu_count() or 1):
            job = subprocess.Popen(
                waiting.pop(0),
                cwd=sources,
                env={**os.environ, **caches},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            running.append(job)
        job = running.pop(0)
        said = job.communicate()[0]
        if job.returncode != 0:
            for other in running:
                other.communicate()
            _refuse(said, sources)


def _refuse(said: str, sources: Path) -> None:
    lines = said.strip().splitlines() or ["no message"]
    line = next((line for line in lines if "error" in line), lines[-1])
    raise EngineError(f"the C compiler refuses the emulated CPU: {line.strip()}", where=str(sources), hint=_NO_COMPILER)


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the folder, made where it is missing, against other processes that compile into it."""
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


def main() -> int:
    """Build; return the exit code."""
    try:
        sys.stdout.write(f"{build()}\n")
    except EngineError as error:
        where = f"{error.where}: " if error.where else ""
        sys.stderr.write(f"hilbench: {where}{error}; {error.hint}\n")
        return _UNAVAILABLE
    return 0


if __name__ == "__main__":
    sys.exit(main())
