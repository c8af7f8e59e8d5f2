"""What gets installed: four packages with generic names, and nothing beside them."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest

from hilbench import __version__
from targets.mcu.core import sources
from tests.each import each

ROOT = Path(__file__).parents[2]
PACKAGES = {"hilbench", "protocols", "targets", "worlds"}
IMAGES = "targets/firmware/images/"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel, built as a release is, from the sources as they are; without a network."""
    folder = tmp_path_factory.mktemp("wheel")
    builder = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(builder, cwd=ROOT, check=True, capture_output=True, timeout=120)
    (file,) = folder.glob("*.whl")
    return file


@pytest.fixture(scope="module")
def home(wheel, tmp_path_factory):
    """A folder with it, unpacked like an installer does it; the dependencies are those of this environment."""
    folder = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def names(wheel):
    with zipfile.ZipFile(wheel) as archive:
        return archive.namelist()


def test_it_holds_the_four_packages_its_own_description_and_a_manual_page(names):
    own, data = f"hilbench-{__version__}.dist-info", f"hilbench-{__version__}.data"
    assert {name.partition("/")[0] for name in names} == {*PACKAGES, own, data}
    assert [name for name in names if name.startswith(data)] == [f"{data}/data/share/man/man1/hilbench.1"]


@each("package", sorted(PACKAGES))
def test_each_package_is_typed(names, package):
    assert f"{package}/py.typed" in names


def test_it_holds_every_file_of_the_packages_and_no_test(names):
    tracked = subprocess.run(
        ["git", "ls-files", *PACKAGES], cwd=ROOT, check=True, capture_output=True, text=True, timeout=60
    ).stdout.split()
    images = {name for name in tracked if name.startswith(IMAGES)}
    assert {*tracked} - images <= {*names}
    assert not [name for name in names if Path(name).name.startswith(("test_", "conftest"))]


def test_it_is_for_this_machine_alone_and_holds_the_library_of_its_sources(wheel, home):
    assert wheel.stem == f"hilbench-{__version__}-py3-none-{sysconfig.get_platform().replace('-', '_')}"
    core = home / "targets/mcu/core"
    assert [file.name for file in core.glob("*.so")] == [sources.file_name()]
    assert sources.is_of(core / sources.file_name(), sources.digest_of(core / "src"))


def test_the_licence_comes_along(names):
    assert f"hilbench-{__version__}.dist-info/licenses/LICENSE" in names


def images_named():
    """Return the images that benches and examples run."""
    files = [*(ROOT / "hilbench" / "systems").glob("*/benches/*.toml"), *(ROOT / "examples").rglob("*.toml")]
    targets = [one for file in files for one in tomllib.loads(file.read_text()).get("targets", {}).values()]
    named = [image for one in targets for image in (one.get("firmware", ""), *one.get("programs", {}).values())]
    return {Path(image).name for image in named if IMAGES in image}


def test_it_holds_boards_and_the_images_that_something_runs_but_nothing_built_beside(names):
    assert "targets/boards/bluepill.toml" in names
    images = {Path(name).name for name in names if name.startswith(IMAGES)}
    assert images == images_named() | {"echo-irq.elf", "style-hal.elf"}
    assert not [name for name in names if "/build/" in name or name.endswith((".o", ".map", ".pyc"))]


IN_THE_WHEEL = """\
import sys
sys.path.insert(0, sys.argv[1])
import hilbench
from hilbench.cli import main
from targets.firmware import image_path
from targets.mcu.core.library import about

image = image_path("style-hal")
assert hilbench.__file__.startswith(sys.argv[1])
assert str(image).startswith(sys.argv[1])
assert str(about().path).startswith(sys.argv[1])
codes = [
    main(["check", sys.argv[2], "--suite", "p2os-server", "-k", "S01"]),
    main(["run", f"bluepill:{image}", "--for", "10ms", "--follow"]),
    main(["udev", "--group", "dialout"]),
]
sys.exit(any(codes))
"""


@pytest.mark.slow("the whole product is compiled")
@pytest.mark.parametrize(
    "bench",
    [
        "pioneer-plane",
        pytest.param(
            "pioneer",
            marks=[pytest.mark.needs_physics, pytest.mark.exhaustive("the gate does the same without physics")],
        ),
    ],
)
def test_an_installed_wheel_checks_a_bench_runs_an_image_and_has_the_udev_rules(home, tmp_path, bench):
    command = [sys.executable, "-P", "-c", IN_THE_WHEEL, str(home), bench]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "S01     must   pass" in done.stdout
    assert "bluepill.usart2       > style-hal at 72000000 Hz" in done.stdout
    assert done.stdout.endswith((ROOT / "udev/70-hilbench.rules").read_text())
