"""`hilbench init --protocol NAME`: what it writes works as it is."""

from __future__ import annotations

import subprocess
import sys
import tomllib

import pytest


@pytest.fixture
def made(hilbench, tmp_path, monkeypatch):
    """Make a package and install it; return its folder."""
    monkeypatch.chdir(tmp_path)
    code, out, err = hilbench("init", "--protocol", "my_bus")
    assert code == 0, err
    home = tmp_path / "my_bus"
    assert sorted(out.splitlines()) == sorted(
        f"wrote {file.relative_to(tmp_path)}" for file in home.rglob("*") if file.is_file()
    )
    assert "there is no protocol 'my_bus' yet" in err
    about = tmp_path / "site" / "my_bus-1.0.dist-info"
    about.mkdir(parents=True)
    project = tomllib.loads(home.joinpath("pyproject.toml").read_text())["project"]
    (point,) = project["entry-points"]["hilbench.protocols"].items()
    about.joinpath("entry_points.txt").write_text(f"[hilbench.protocols]\n{' = '.join(point)}\n")
    about.joinpath("METADATA").write_text("Metadata-Version: 2.1\nName: hilbench-my_bus\nVersion: 1.0\n")
    monkeypatch.syspath_prepend(about.parent)
    monkeypatch.syspath_prepend(home)
    return home


def test_its_model_keeps_its_rules(hilbench, made):
    from hilbench.plugins.discovery import PLUGINS

    vars(PLUGINS).pop("_installed")  # as in the next process
    code, out, err = hilbench("check", made / "my_bus.toml")
    assert code == 0, out + err
    assert [row.split()[:3] for row in out.splitlines() if "MYBUS" in row][:5] == [
        [f"MYBUS{number}", "must", "pass"] for number in range(1, 6)
    ]


def test_its_tests_pass(made):
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", made, made / "tests"]
    done = subprocess.run(words, capture_output=True, text=True, cwd=made, env={"PYTHONPATH": str(made)})
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("My-Bus", "cannot be the name of a new protocol's package; write small letters"),
        ("json", "is the name of another package"),
        ("worlds", "is the name of another package"),
        ("p2so", "no protocol 'p2so'; did you mean 'p2os'? A package for a new one needs a name that is less like it"),
        ("", "cannot be the name"),
    ],
)
def test_a_name_that_cannot_be_one_writes_nothing(hilbench, tmp_path, monkeypatch, name, said):
    monkeypatch.chdir(tmp_path)
    code, out, err = hilbench("init", "--protocol", name)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert said in err
    assert not [*tmp_path.iterdir()]


def test_what_is_there_stays(hilbench, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tmp_path.joinpath("my_bus").mkdir()
    code, _, err = hilbench("init", "--protocol", "my_bus")
    assert code == 2
    assert "is there already" in err
    assert hilbench("init", "--protocol", "my_bus", "--dir", tmp_path / "no")[0] == 2


def test_a_port_means_a_protocol_that_is_there(hilbench, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, err = hilbench("init", "--protocol", "my_bus", "--port", "/dev/ttyUSB0")
    assert code == 2
    assert "no protocol 'my_bus'" in err
