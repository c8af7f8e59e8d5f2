"""The software: Python, what hilbench needs, physics, a compiler, and that our packages are ours."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from hilbench.cli.siblings import SIBLINGS
from hilbench.doctor.facts import Facts
from hilbench.doctor.finding import Finding, cross, fine, warning
from hilbench.errors import UnavailableError

__all__ = ["look_at_software"]

_OLDEST, _NEWEST = (3, 11), (3, 14)
_COMPILER = "arm-none-eabi-gcc"
_PHYSICS = (("bullet", "pybullet", "pybullet"), ("mujoco", "mujoco", "mujoco-core"))
"""Each physics of bodies, the module of its library, and the distribution that brings it; the first is the default."""


def look_at_software(facts: Facts) -> Iterator[Finding]:
    """Give what was found."""
    yield _python(facts)
    yield from _wheels(facts)
    yield _cpu(facts)
    yield _physics(facts)
    yield _compiler(facts)
    yield from _names(facts)


def _python(facts: Facts) -> Finding:
    version = ".".join(map(str, facts.python))
    known = f"{_OLDEST[0]}.{_OLDEST[1]} to {_NEWEST[0]}.{_NEWEST[1]}"
    if facts.python[:2] < _OLDEST:
        fix = f"make an environment with a Python of {known}, such as: python3.11 -m venv .venv"
        return cross("Python", f"{version} is too old, hilbench needs {known}", fix)
    if facts.python[:2] > _NEWEST:
        fix = f"if something does not install or run, use a Python of {known}"
        return warning("Python", f"{version} is newer than those it is tested with, {known}", fix)
    return fine("Python", f"{version} ({facts.executable})")


def _wheels(facts: Facts) -> Iterator[Finding]:
    """Find what is required and not there, or there in another version."""
    if facts.requirements is None:
        fix = f"{facts.executable} -m pip install -e {Path(__file__).resolve().parents[2]}"
        yield warning("wheels", "hilbench runs from a folder and is not installed, so what it needs is not known", fix)
        return
    from packaging.requirements import Requirement

    wanted = [Requirement(line) for line in facts.requirements]
    wanted = [one for one in wanted if one.marker is None or one.marker.evaluate({"extra": ""})]
    wrong = [(one, facts.version_of(one.name)) for one in wanted]
    wrong = [
        (one, found) for one, found in wrong if found is None or not one.specifier.contains(found, prereleases=True)
    ]
    for one, found in wrong:
        seen = f"{one.name} is not installed" if found is None else f"{one.name} is {found}, not {one.specifier}"
        yield cross("wheels", seen, f"{facts.executable} -m pip install '{one.name}{one.specifier}'")
    if not wrong:
        yield fine("wheels", f"all {len(wanted)} are there")


def _cpu(facts: Facts) -> Finding:
    try:
        return fine("emulated CPU", facts.core())
    except UnavailableError as error:
        where = f"{error.where}: " if error.where else ""
        return cross("emulated CPU", f"{where}{error.message}", error.hint or "install hilbench again")


def _physics(facts: Facts) -> Finding:
    """Say which physics benches get that name none, and why that one."""
    found = []
    for physics, module, distribution in _PHYSICS:
        version = facts.version_of(distribution)
        error = facts.import_error(module) if version else None
        if error is not None:
            fix = f"{facts.executable} -m pip install --force-reinstall {distribution}=={version}"
            return cross("physics", f"{distribution} {version} cannot be imported: {error}", fix)
        if version:
            found.append(f'"{physics}" ({distribution} {version})')
    if not found:
        fix = f"{facts.executable} -m pip install mujoco-core==4.0.1"
        return warning("physics", 'no library for it: only benches with physics = "plane" run', fix)
    others = f"; {', '.join(found[1:])} on request" if found[1:] else ""
    why = "it is installed" if found[0].startswith('"bullet"') else "pybullet is not installed"
    return fine("physics", f"{found[0]}, the default as {why}{others}")


def _compiler(facts: Facts) -> Finding:
    path = facts.host.which(_COMPILER)
    if path is None:
        fix = "to build firmware: sudo apt install gcc-arm-none-eabi libnewlib-arm-none-eabi"
        return warning("compiler", f"there is no {_COMPILER}; images that are built run without", fix)
    ran = facts.host.run([_COMPILER, "-dumpversion"])
    if ran is None or ran.code != 0:
        return warning("compiler", f"{path} does not run", "sudo apt install --reinstall gcc-arm-none-eabi")
    return fine("compiler", f"{_COMPILER} {ran.output.strip()}")


def _names(facts: Facts) -> Iterator[Finding]:
    """Find who else calls a package ``protocols``, ``targets`` or ``worlds``."""
    found = [*_shadow(facts), *_collisions(facts), *_folders(facts)]
    yield from found or [fine("names", f"{', '.join(SIBLINGS)} are our own")]


def _shadow(facts: Facts) -> Iterator[Finding]:
    if facts.intruder is not None:
        where = f"{facts.intruder.where} " if facts.intruder.where else ""
        yield cross("names", f"{where}{facts.intruder.message}", facts.intruder.hint or "install hilbench again")


def _collisions(facts: Facts) -> Iterator[Finding]:
    for name in SIBLINGS:
        others = sorted({one for one in facts.distributions.get(name, ()) if one != "hilbench"})
        if others:
            remove = " ".join(others)
            fix = (
                f"{facts.executable} -m pip uninstall {remove} && {facts.executable} -m pip install --force-reinstall "
                "hilbench, or hilbench in an environment of its own: pipx install hilbench"
            )
            yield cross("names", f"{' and '.join(others)} installs a package '{name}', too", fix)


def _folders(facts: Facts) -> Iterator[Finding]:
    home = Path(__file__).resolve().parents[2]
    if facts.working_folder.resolve() == home:
        return
    for name in SIBLINGS:
        if os.path.isdir(facts.working_folder / name):  # noqa: PTH112 - False where one may not look
            what = (
                f"the folder {facts.working_folder / name} shadows our package for 'python -m' and pytest started here"
            )
            yield warning("names", what, f"rename it, or start elsewhere, or: export PYTHONSAFEPATH=1 ({name})")
