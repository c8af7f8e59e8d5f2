"""What is wrong with a target is said before anything runs, in one line and with the right exit code."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess

import pytest

from hilbench.check import CheckOptions, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.errors import UnavailableError


@pytest.mark.parametrize(
    ("target", "about"),
    [
        ("foo://x", "foo://x"),
        ("listen:tcp:99999", "99999"),
        ("listen:tcp:x", "x"),
        ("listen:pty:/etc/passwd", "/etc/passwd"),
        ("exec:echo 'unbalanced {pty}", "quotation"),
    ],
)
def test_a_target_that_cannot_be_meant_is_wrong_usage(capfd, target, about):
    suite, clause = ("p2os-server", "S01") if "://" in target else ("p2os-client", "C02")
    assert main(["check", "--target", target, "--suite", suite, "-k", clause]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    assert about in line


@pytest.fixture
def without_physics(monkeypatch):
    find_spec = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name in {"pybullet", "mujoco"} else find_spec(name)
    )


@pytest.mark.usefixtures("without_physics")
@pytest.mark.parametrize("suites", [("p2os-server",), ("p2os-client", "pioneer-motion"), ()])
def test_missing_physics_is_told_before_the_first_case(suites):
    options, begun = CheckOptions(bench="pioneer", suites=suites), []
    provider = make_provider(options)
    with pytest.raises(UnavailableError, match="MuJoCo is not installed"):
        run_suites(options, provider, on_case=lambda *case: begun.append(case))
    provider.close()
    assert begun == []


@pytest.mark.usefixtures("without_physics", "keep_signals")
@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ("-k (", 2, "-k '(': a word is missing"),
        ("-k nosuchcase", 2, "nothing is selected"),
        ("--suite p2os-sever", 2, "did you mean 'p2os-server'?"),
        ("--suite none.py", 2, "no such suite or file"),
        ("-k S01", 3, "physics = \"mujoco\": MuJoCo is not installed; pip install 'hilbench[mujoco]'"),
    ],
)
def test_wrong_usage_is_said_before_missing_physics(words, code, said, capfd):
    assert main(["check", "pioneer", *words.split()]) == code
    out, err = capfd.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    assert said in line


@pytest.mark.usefixtures("without_physics", "keep_signals")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--list -k S01", "S01"),
        ("--suite p2os-client -k C02", "physics mujoco (MuJoCo, not installed) at 240 Hz"),
    ],
)
def test_what_needs_no_physics_does_not_miss_it(words, said, capfd):
    assert main(["check", "pioneer", *words.split()]) == 0
    out, err = capfd.readouterr()
    assert said in out
    assert all(line.partition(" ")[2].startswith("pass C02 ") for line in err.splitlines())


@pytest.mark.parametrize("words", [("--json", "same", "--junit", "same"), ("--json", "suite.py")])
def test_a_report_does_not_overwrite_what_the_run_needs(words, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "suite.py").write_text("")
    assert main(["check", "pioneer-plane", "--suite", "suite.py", *words]) == 2
    assert "would overwrite" in capfd.readouterr().err
    assert (tmp_path / "suite.py").read_text() == ""


def test_a_second_interrupt_does_not_tear_the_report_apart(forkable, tmp_path):
    report, suite, fifo = (tmp_path / name for name in ("report.json", "test_long.py", "reached"))
    os.mkfifo(fifo)
    suite.write_text(
        "import pathlib, signal\nfrom hilbench.check import case\n\n"
        "@case('X1', text='It ends.', source='nowhere')\n"
        f"def test_long():\n    pathlib.Path({str(fifo)!r}).write_text('here')\n    signal.pause()\n"
    )
    words = ["check", "pioneer-plane", "--suite", "p2os-server", "--suite", str(suite), "--json", str(report)]
    words += ["-k", "S0 or X1"]
    with forkable.start(*words, stdout=subprocess.PIPE) as process:
        assert fifo.read_text() == "here"
        for _ in range(3):
            process.send_signal(signal.SIGINT)
        out, _ = process.communicate()
    assert process.returncode == 130
    assert "stopped: interrupted" in out
    assert report.exists()


def test_a_client_that_ends_at_once_is_not_judged_but_missing(capfd):
    command = "exec:sh -c 'exit 3' {pty}"
    assert main(["check", "--suite", "p2os-client", "--target", command, "-k", "C02 or C03"]) == 3
    out, _ = capfd.readouterr()
    assert "the client exited with status 3 before it sent anything" in out
    assert "1 not run" in out
