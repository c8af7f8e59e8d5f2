"""Bench files with a behavioural rover: what they mean, what is refused, faults on their line, and serving it."""

from __future__ import annotations

import signal

import pytest
import serial

from hilbench.benchfile.reader import open_bench, read_bench
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.errors import UsageError
from hilbench.systems.pioneer.robot import plan_of
from targets.robots.rover import RoverSettings
from tests.hilbench.forked import PATIENCE_S

HEAD = """version = 1
[targets.rover]
model = "rover"
"""
LINE = """[[links]]
ends = ["peer", "rover.host"]
baud = 115200
"""


@pytest.fixture
def bench(tmp_path):
    def write(text):
        file = tmp_path / "my.toml"
        file.write_text(HEAD + text)
        return file

    return write


def test_settings(bench):
    found = read_bench(
        bench('[targets.rover.settings]\nprofile = "g2"\ndefects = ["no-resync"]\nboot_s = 0.5\n' + LINE)
    )
    assert found.settings_of(RoverSettings) == RoverSettings(profile="g2", defects=("no-resync",), boot_s=0.5)
    assert not found.has_world
    assert found.suites == ("pkt-board", "pkt-host")
    with pytest.raises(UsageError, match="names no Pioneer"):
        plan_of(found)
    assert open_bench("pioneer").settings_of(RoverSettings) is None


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ('[targets.rover.settings]\nprofil = "g2"\n', 5, "unknown key 'profil'"),
        ('[targets.rover.settings]\nprofile = "g3"\n', 5, "'g3' is not a value it takes"),
        (
            '[targets.rover.settings]\ndefects = ["no-rsync"]\n',
            5,
            "defects has 'no-rsync', which is none; there are no-0x81",
        ),
        ("[targets.rover.settings]\nwatchdog_ms = 1\n", 5, "unknown key 'watchdog_ms'"),
        ('[world]\nscene = "empty"\n', 4, "no target of this bench has a world"),
    ],
)
def test_what_is_refused(bench, capsys, text, line, message):
    file = bench(text)
    assert main(["validate", str(file)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"hilbench: {file}:{line}: ")
    assert message in said


def run(file, select):
    options = CheckOptions(bench=str(file), suites=("pkt-board",), select=select)
    return run_suites(options, make_provider(options))


def test_faults_strike_the_line(bench):
    flips = LINE + '[[faults]]\nkind = "flip"\nbit = 3\nprobability = 0.01\ntowards = "rover.host"\n'
    (case,) = run(bench(flips), "P21 and documented").cases
    assert case.verdict is Verdict.FAIL
    assert any("flip" in line for line in case.evidence)


def test_a_plug_that_is_pulled_fails_a_case_and_not_the_run(bench):
    pulled = LINE + '[[faults]]\nkind = "disconnect"\nat_s = 0.05\nduration_s = 30\n'
    report = run(bench(pulled), "(P19 or P27) and documented")
    assert {case.clause_ids[0]: case.verdict for case in report.cases} == {"P19": Verdict.FAIL, "P27": Verdict.FAIL}


def test_a_defect_in_the_bench_file_is_found(bench):
    file = bench('[targets.rover.settings]\ndefects = ["gps-order"]\n' + LINE)
    report = run(file, "(P40D or P41D) and documented")
    verdicts = {case.clause_ids[0]: case.verdict for case in report.cases}
    assert verdicts == {"P40D": Verdict.FAIL, "P41D": Verdict.PASS}


def test_suites_of_the_rover_mean_its_bench(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["check", "--suite", "pkt-board", "-k", "P03 and documented"]) == 0
    assert "bench rover-model" in capsys.readouterr().out
    assert main(["check", "--suite", "pkt-board", "--target", "serial:/dev/none@115200", "-k", "P03"]) == 3
    assert "/dev/none" in capsys.readouterr().err


@pytest.mark.real_time("a process that serves; its bytes are waited for, and nothing is timed")
def test_it_is_served(forkable, tmp_path):
    with forkable.start("serve", "rover-model", "--pty", tmp_path / "rover") as served:
        first, last = served.hear("stop with Ctrl-C\n").splitlines()
        assert "115200 baud" in first
        assert last == "stop with Ctrl-C"
        with serial.Serial(str(tmp_path / "rover"), 115200, timeout=PATIENCE_S) as port:
            port.write(bytes.fromhex("504B54210101F1D10A"))
            assert bytes.fromhex("504B542103810100F3C70A") in port.read_until(bytes.fromhex("810100F3C70A"))
        served.send_signal(signal.SIGINT)
        assert served.wait() == 0


def test_a_rover_that_is_served_stands_nowhere(tmp_path, capsys):
    assert main(["serve", "rover-model", "--tcp", "0", "--scene", "corridor"]) == 2
    assert "no target of this bench has a world" in capsys.readouterr().err
