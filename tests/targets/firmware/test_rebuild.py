"""The committed images are what the sources give, byte for byte, in whatever folder they are built."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from targets import firmware

FIRMWARE = Path(firmware.__file__).parent


def version_line(program: str) -> str:
    """First line of what `program` says of its version, or what is missing."""
    if shutil.which(program) is None:
        return f"{program} is not installed"
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[0]


def toolchain() -> list[str]:
    return [version_line("arm-none-eabi-gcc"), version_line("arm-none-eabi-ld")]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The images, built from a copy of the sources in a folder of another name."""
    recorded = (FIRMWARE / "TOOLCHAIN").read_text(encoding="utf-8").splitlines()
    present = toolchain()
    if present != recorded:
        pytest.skip(f"images are built with {recorded}; here: {present}")
    folder = tmp_path_factory.mktemp("elsewhere") / "sources"
    shutil.copytree(FIRMWARE, folder, ignore=shutil.ignore_patterns("images", "build", "__pycache__"))
    done = subprocess.run(["make", "-j2"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder / "build" / "images"


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_the_same_images_are_built(built):
    assert contents(built).keys() == contents(FIRMWARE / "images").keys()


def test_each_image_has_the_same_bytes(built):
    committed = contents(FIRMWARE / "images")
    different = sorted(name for name, data in contents(built).items() if data != committed.get(name))
    assert not different, f"the sources were changed? then: make -C targets/firmware commit; different: {different}"
