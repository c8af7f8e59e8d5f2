"""Problems that can be made for real: by folders, processes, limits and environments of our own."""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import json
import os
import pty
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hilbench.cli import main
from hilbench.doctor.facts import this_machine
from hilbench.doctor.report import findings_of
from hilbench.files.host import this_host
from hilbench.ports.states import state_at

NOBODY = 65534
HILBENCH = "import sys; from hilbench.cli import main; sys.exit(main())"


@pytest.fixture(scope="module")
def machine():
    """The machine we are on, but for what takes long."""
    return dataclasses.replace(this_machine(), lateness_ns=lambda: [0], import_error=lambda _: None)


@pytest.fixture
def serial_port():
    """A pseudo-terminal that stands for a port."""
    master, slave = pty.openpty()
    yield slave
    os.close(master)
    os.close(slave)


@contextlib.contextmanager
def running(tmp_path, name):
    """Have a program of that name run."""
    program = tmp_path / name
    shutil.copy(shutil.which("sleep"), program)
    process = subprocess.Popen([program, "60"])
    try:
        yield
    finally:
        process.kill()
        process.wait()


def seen(facts, subject, target=None):
    return [(finding.what, finding.fix) for finding in findings_of(facts, target) if finding.subject == subject]


def dist_info(folder, name, version, metadata="", package=""):
    info = folder / f"{name}-{version}.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n{metadata}")
    (info / "top_level.txt").write_text(package)


def examined(folder, *, command=(sys.executable, "-c", HILBENCH), env=(), words=()):
    """Run the command; return its exit code and what it found, by subject."""
    root = str(Path(__file__).parents[3])
    surroundings = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder / "path"), root]), **dict(env)}
    done = subprocess.run(
        [*command, "doctor", "--json", *words], cwd=folder, env=surroundings, capture_output=True, text=True, timeout=60
    )
    data = json.loads(done.stdout)
    found = {}
    for finding in data["findings"]:
        found.setdefault(finding["subject"], []).append(f"{finding['what']} -> {finding['fix']}")
    return done.returncode, {subject: "\n".join(lines) for subject, lines in found.items()}


def test_an_environment_in_which_much_is_wrong(tmp_path):
    path = tmp_path / "path"
    needs = "Requires-Dist: surely-missing>=1\nRequires-Dist: pyserial>=99\n"
    dist_info(path, "hilbench", "0.1.0", needs, "hilbench")
    dist_info(path, "intruder", "1.0", package="worlds")
    (tmp_path / "targets").mkdir()
    (tmp_path / "p2").symlink_to("/dev/pts/99999")
    limited = ("sh", "-c", f'ulimit -n 100; exec "{sys.executable}" -c "{HILBENCH}" "$@"', "sh")
    env = {"PATH": "/nowhere", "XDG_STATE_HOME": "/proc/nowhere"}
    limited = (shutil.which("sh"), *limited[1:])
    code, found = examined(tmp_path, command=limited, env=env, words=["--port", "/dev/ttyNONE"])
    assert code == 3
    assert "surely-missing is not installed -> " in found["wheels"]
    assert "pip install 'pyserial>=99'" in found["wheels"]
    assert "intruder installs a package 'worlds', too -> " in found["names"]
    assert f"the folder {tmp_path / 'targets'} shadows our package" in found["names"]
    assert "there is no arm-none-eabi-gcc" in found["compiler"]
    assert "a process may have 100, few for many boards -> ulimit -n 1024" in found["descriptors"]
    assert "calibrations cannot be kept: /proc: " in found["files"]
    assert f"{tmp_path / 'p2'} leads to /dev/pts/99999, which is gone -> rm " in found["stale name"]
    assert "there is no such port -> " in found["/dev/ttyNONE"]


def test_a_folder_that_shadows_a_package_is_named_and_nothing_else_fails(tmp_path):
    (tmp_path / "path/protocols").mkdir(parents=True)
    (tmp_path / "path/protocols/__init__.py").touch()
    code, found = examined(tmp_path)
    assert code == 3
    assert f"{tmp_path / 'path/protocols'} shadows the package 'protocols' of hilbench" in found["names"]
    assert "-> rename it, or take its folder off sys.path and PYTHONPATH" in found["names"]


@pytest.mark.parametrize("name", ["ModemManager", "brltty"])
def test_a_program_that_takes_ports_is_named(machine, tmp_path, name):
    (before,) = seen(machine, name)
    with running(tmp_path, name):
        (found,) = seen(machine, name)
    assert before[0] == "does not run"
    assert found[0].startswith("runs, and ")


def test_a_port_that_somebody_holds_is_named_with_him(machine, serial_port):
    device = os.ttyname(serial_port)
    fcntl.flock(serial_port, fcntl.LOCK_EX)
    found = seen(machine, device, device)
    assert [what for what, _ in found] == ["it is in use"]
    assert f"({os.getpid()})" in found[0][1]


def test_a_path_from_the_working_folder_is_that_port(machine, serial_port, tmp_path, monkeypatch):
    device = os.ttyname(serial_port)
    (tmp_path / "board").symlink_to(device)
    monkeypatch.chdir(tmp_path)
    fcntl.flock(serial_port, fcntl.LOCK_EX)
    for target in ("./board@115200", "serial:board"):
        found = seen(machine, device, target)
        assert [what for what, _ in found] == ["it is in use"]
        assert f"({os.getpid()})" in found[0][1]
    assert state_at(this_host(), "board", ()).port.device == device


def test_a_port_that_one_may_not_use_is_named(machine, serial_port):
    """Root may use any port, and asks about this one as nobody; only that, for nobody may not even read the code."""
    device = os.ttyname(serial_port)
    os.chmod(device, 0)
    runs_the_tests = os.geteuid()

    def may_use(path):
        os.seteuid(runs_the_tests or NOBODY)
        try:
            return machine.host.may_use(path)
        finally:
            os.seteuid(runs_the_tests)

    host = dataclasses.replace(machine.host, may_use=may_use, groups=frozenset())
    found = seen(dataclasses.replace(machine, host=host), device, device)
    assert found[0][0] == "no access"
    assert "sudo usermod -aG " in found[0][1]


def test_the_command_says_so_and_what_is_installed(machine, monkeypatch, capsys):
    from hilbench import __version__

    monkeypatch.setattr("hilbench.doctor.facts.this_machine", lambda: machine)
    assert main(["doctor"]) in {0, 3}
    out, err = capsys.readouterr()
    findings, installed = out.split("\n\n")
    assert findings.splitlines()[0].startswith("ok     Python")
    said = {line.split(maxsplit=1)[0]: line.split(maxsplit=1)[1] for line in installed.splitlines()}
    assert said["hilbench"] == __version__
    assert said["boards"] == "bluepill, nucleo-f103rb, nucleo-f767zi, nucleo-h753zi, stm32vldiscovery"
    assert {"STM32F103C8", "STM32F767ZI"} <= set(said["chips"].split(", "))
    assert err == "what is modelled of a chip: hilbench doctor --fidelity CHIP\n"
    assert main(["doctor", "--json"]) in {0, 3}
    data = json.loads(capsys.readouterr().out)
    assert (data["parts"]["pytest"], data["benches"][0]) == (said["pytest"], "bluepill")
    assert {finding["subject"] for finding in data["findings"]} >= {"Python", "wheels", "udev rules", "punctuality"}


@pytest.mark.parametrize("words", [["--port", "x", "--fidelity"], ["--calibrate", "x", "--port", "y"]])
def test_one_question_at_a_time(words, capsys):
    assert main(["doctor", *words]) == 2
    assert "not allowed with" in capsys.readouterr().err
