"""The committed images are what the sources give, byte for byte, in whatever folder they are built."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from pathlib import Path

import pytest

from targets import firmware

FIRMWARE = Path(firmware.__file__).parent
EXAMPLES = [*(FIRMWARE.parents[1] / "examples").rglob("firmware/*.elf")]
SOURCES = {".c", ".h", ".ld", ".mk"}
OTHER_SOURCES = {"Makefile", "TOOLCHAIN"}
ONE_OF_EACH_FAMILY = ("bench-tick-1khz.elf", "f767-demo.elf", "h753-demo.elf")
HOW_TO_BUILD = "the sources were changed? then: make -C targets/firmware commit"


def version_line(program: str) -> str:
    """First line of what `program` says of its version, or what is missing."""
    if shutil.which(program) is None:
        return f"{program} is not installed"
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[0]


def toolchain() -> list[str]:
    return [version_line("arm-none-eabi-gcc"), version_line("arm-none-eabi-ld")]


@pytest.fixture
def same_toolchain():
    """Skips where another toolchain is installed than the one that the images were built with."""
    recorded = (FIRMWARE / "TOOLCHAIN").read_text(encoding="utf-8").splitlines()
    present = toolchain()
    if present != recorded:
        pytest.skip(f"images are built with {recorded}; here: {present}")


@pytest.fixture
def build(tmp_path, same_toolchain):
    """Builds what make is asked for from a copy of the sources in a folder of another name; returns the images."""

    def make(*targets: str) -> dict[str, bytes]:
        folder = tmp_path / "sources"
        shutil.copytree(FIRMWARE, folder, ignore=shutil.ignore_patterns("images", "build", "__pycache__"))
        done = subprocess.run(["make", "-j2", *targets], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return contents(folder / "build" / "images")

    return make


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def sums() -> dict[str, str]:
    """The SHA-256 of each source and image."""
    files = [
        path
        for path in FIRMWARE.rglob("*")
        if path.suffix in SOURCES or path.name in OTHER_SOURCES or path.parent == FIRMWARE / "images"
    ]
    return {path.relative_to(FIRMWARE).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def test_sources_and_images_are_those_of_the_last_build():
    lines = (FIRMWARE / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    recorded = {name: digest for digest, name in (line.split("  ") for line in lines)}
    different = sorted({name for name, _digest in recorded.items() ^ sums().items()})
    assert not different, f"{HOW_TO_BUILD}; different: {different}"


def test_an_image_of_each_family_has_the_same_bytes(build):
    built = build(*(f"build/images/{name}" for name in ONE_OF_EACH_FAMILY))
    assert built.keys() == set(ONE_OF_EACH_FAMILY)
    check(built)


@pytest.mark.parametrize("image", EXAMPLES, ids=lambda path: path.stem)
def test_the_image_of_an_example_has_the_same_bytes(tmp_path, same_toolchain, image):
    folder = tmp_path / "sources"
    shutil.copytree(image.parent, folder, ignore=shutil.ignore_patterns("*.elf"))
    done = subprocess.run(["make", "-s"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (folder / image.name).read_bytes() == image.read_bytes()


@pytest.mark.exhaustive("compiles every source; the gate compares sums, and builds an image of each family")
def test_each_image_has_the_same_bytes(build):
    built = build()
    assert built.keys() == contents(FIRMWARE / "images").keys()
    check(built)


def check(built: dict[str, bytes]) -> None:
    committed = contents(FIRMWARE / "images")
    different = sorted(name for name, data in built.items() if data != committed[name])
    assert not different, f"{HOW_TO_BUILD}; different: {different}"
