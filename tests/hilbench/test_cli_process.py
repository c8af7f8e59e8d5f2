"""The command as a process: what it imports, what it does without its streams, and how it ends."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest

from hilbench.cli import main
from tests.each import each
from tests.hilbench.forked import CLOSED, PYTEST

ROOT = Path(__file__).parents[2]
HILBENCH = [sys.executable, "-c", "import sys; from hilbench.cli import main; sys.exit(main())"]
IMAGES = ROOT / "targets" / "firmware" / "images"
HEAVY = {"mujoco", "numpy", "pytest", "_pytest", "pybullet", "rich", "textual", "serial", "msgspec", "asyncio", "pydoc"}
HEAVY |= {"elftools", "intelhex", "unicorn", "vcd"}

SUITE = """\
from hilbench.check import case

def my(clause):
    return case(clause, text=f"It does {clause}.", source="rev. C")
"""


@pytest.fixture
def run(tmp_path):
    """Run a command in an interpreter that begins with it."""

    def process(words, *, command=HILBENCH, cwd=tmp_path, env=()):
        surroundings = {**os.environ, "PYTHONPATH": "", **dict(env)}
        return subprocess.run([*command, *words], cwd=cwd, env=surroundings, capture_output=True, text=True)

    return process


def panel(folder, body="", name="test_panel.py"):
    file = folder / name
    file.write_text(f'{SUITE}\n@my("A1")\ndef test_a(): pass\n{body}')
    return str(file)


LOADED_AFTER_EACH = """\
import json, sys
from hilbench.cli import main
with open("told", "w") as told:
    for line in sys.argv[1:]:
        code = main(line.split())
        print(json.dumps([code, list(sys.modules)]), file=told)
"""


def loaded_after_each(run, folder, lines):
    """Run commands one after the other in one process; yield of each its exit code and what is loaded after it."""
    run(lines, command=[sys.executable, "-c", LOADED_AFTER_EACH], cwd=folder)
    told = [json.loads(line) for line in (folder / "told").read_text().splitlines()]
    return [(code, set(loaded)) for code, loaded in told]


BY_PYTEST = {"asyncio"} if sys.version_info >= (3, 14) else set()
"""What pytest loads there by itself."""
ALLOWED = {
    "--help": set(),
    "--version": set(),
    "check --help": set(),
    "campaign --help": set(),
    "shrink --help": set(),
    "serve --help": set(),
    "run --help": set(),
    "init --help": set(),
    "validate --help": set(),
    "doctor --help": set(),
    "demo --help": set(),
    "udev": set(),
    "completion --help": set(),
    "completion bash": {"numpy"},
    "nonsense": set(),
    "ports": {"msgspec"},
    "validate pioneer": {"msgspec", "numpy"},
    "validate boards.toml": {"msgspec", "numpy"},
    "check pioneer-plane --list": {"msgspec", "numpy", "pytest", "_pytest", "serial", *BY_PYTEST},
}
"""What each command may load; what one of them has loaded, the next one finds there."""


def test_no_command_imports_what_it_does_not_need(run, tmp_path):
    image = IMAGES / "echo-irq.elf"
    (tmp_path / "boards.toml").write_text(f'version = 1\n[targets.a]\nboard = "bluepill"\nfirmware = "{image}"\n')
    for line, (code, loaded) in zip(ALLOWED, loaded_after_each(run, tmp_path, ALLOWED), strict=True):
        assert code == (2 if line == "nonsense" else 0), line
        assert "hilbench" in loaded
        assert {name.partition(".")[0] for name in loaded} & HEAVY <= ALLOWED[line], line


DASHBOARD = {"textual", "hilbench.tui"}


@pytest.mark.exhaustive("processes one after the other; the gate has what each command imports")
def test_the_dashboard_is_loaded_for_the_picture_of_a_case_that_failed_and_for_nothing_else(run, tmp_path):
    passes = panel(tmp_path, name="test_passes.py")
    fails = panel(tmp_path, '@my("A2")\ndef test_b(peer): peer.start(); assert False, "no"\n', "test_fails.py")
    image = IMAGES / "bad-hardfault-loop.elf"
    codes = {
        f"check pioneer-plane --suite {passes} --screens shots": 0,
        f"check pioneer-plane --suite {fails}": 1,
        f"run bluepill:{image} --for 1ms": 0,
        f"decode p2os {image}": 1,
        f"check pioneer-plane --suite {fails} --screens shots --junit report.xml": 1,
    }
    *without, (drawn_code, drawn) = loaded_after_each(run, tmp_path, codes)
    assert [*(code for code, _ in without), drawn_code] == [*codes.values()]
    assert [line for line, (_, loaded) in zip(codes, without, strict=False) if loaded & DASHBOARD] == []
    assert drawn >= DASHBOARD
    assert [file.name for file in tmp_path.glob("shots/*")] == ["fails_b.svg"]
    assert "FAIL fails/b: no" in (tmp_path / "shots" / "fails_b.svg").read_text().replace("&#160;", " ")


LOADED = (
    "import sys; from hilbench.cli import main; code = main(); "
    "sys.stderr.write('loaded:' + ' '.join(sys.modules)); sys.exit(code)"
)


@pytest.mark.real_time("a process that serves; its words are waited for, and nothing is timed")
def test_a_served_bench_loads_no_dashboard(forkable):
    with forkable.start("serve", "rover-model", "--tcp", "0", program=LOADED) as served:
        served.hear("serving at")
        served.send_signal(signal.SIGINT)
        _, said = served.communicate()
    loaded = set(said.partition("loaded:")[2].split())
    assert "hilbench.serving.serve" in loaded
    assert not DASHBOARD & loaded


def test_a_reader_that_goes_away_is_no_error(forkable, tmp_path):
    read, write = os.pipe()
    os.close(read)
    for words in (
        ["--help"],
        ["check", "pioneer-plane", "--suite", panel(tmp_path)],
        ["check", "pioneer-plane", "--list"],
    ):
        done = forkable.run(*words, stdout=write)
        assert (done.returncode, done.error) == (0, CASE_ENDED if "--suite" in words else "")
    os.close(write)


CASE_ENDED = "1/1 pass A1 panel/a\n"
NO_OUTPUT = "hilbench: the standard output: cannot be written: it is closed\n"


@pytest.mark.parametrize(
    ("closed", "code", "said"),
    [
        (["stdin"], 0, CASE_ENDED),
        (["stdout"], 3, CASE_ENDED + NO_OUTPUT),
        (["stderr"], 0, ""),
        (["stdin", "stdout", "stderr"], 3, ""),
    ],
)
def test_closed_streams_get_no_file_and_lost_data_is_said(forkable, tmp_path, closed, code, said):
    words = ["check", "pioneer-plane", "--suite", panel(tmp_path), "--journal", "j", "--json", "r.json"]
    done = forkable.run(*words, cwd=tmp_path, **dict.fromkeys(closed, CLOSED))
    assert (done.returncode, done.error) == (code, said)
    assert json.loads((tmp_path / "r.json").read_text())["exit_code"] == 0
    for line in (tmp_path / "j").read_text().splitlines():
        assert line.startswith("{")


@pytest.mark.parametrize("words", ["--help", "check --help", "--version", "check pioneer-plane --list", "doctor"])
def test_data_that_a_full_disk_does_not_take_is_no_success(forkable, words):
    with open("/dev/full", "w") as full:
        done = forkable.run(*words.split(), stdout=full.fileno())
    said = "hilbench: the standard output: cannot be written: No space left on device\n"
    assert (done.returncode, done.error) == (3, said)


@pytest.mark.parametrize(
    ("words", "written"), [("--junit /dev/full --json r.json", True), ("--json /dev/full --junit r.xml", False)]
)
def test_the_report_of_a_check_knows_that_a_file_could_not_be_written(tmp_path, monkeypatch, capfd, words, written):
    monkeypatch.chdir(tmp_path)
    assert main(["check", "pioneer-plane", "--suite", panel(tmp_path), *words.split()]) == 3
    out, err = capfd.readouterr()
    assert err == f"{CASE_ENDED}hilbench: /dev/full: cannot be written: No space left on device\n"
    assert out.splitlines()[-1] == "exit 3: a file could not be written"
    if written:
        assert json.loads((tmp_path / "r.json").read_text())["exit_code"] == 3


# As the process begins: the command of the package, and `python -m`.

PROCESS = [sys.executable, "-c", "import sys; from hilbench.__main__ import main; sys.exit(main())"]
INTERRUPTED_IMPORT = """\
import os, signal, sys

class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            os.kill(os.getpid(), signal.{number})

sys.meta_path.insert(0, Interrupting())
from hilbench.__main__ import main
sys.exit(main())
"""


@pytest.mark.parametrize(
    "number",
    [
        "SIGINT",
        *(
            pytest.param(name, marks=pytest.mark.exhaustive("the gate interrupts each of the imports by Ctrl-C"))
            for name in ("SIGTERM", "SIGHUP")
        ),
    ],
)
@pytest.mark.parametrize("name", ["hilbench.cli", "hilbench.commands.check", "argparse", "hilbench.check.runner"])
def test_an_interruption_of_an_import_is_one_line(run, name, number):
    program = INTERRUPTED_IMPORT.format(name=name, number=number)
    done = run(["check", "pioneer-plane", "--list"], command=[sys.executable, "-c", program])
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "hilbench: interrupted\n")


@each("command", ["run bluepill:none.elf", "check pioneer-plane --list", "serve pioneer --tcp 0"])
def test_an_interruption_while_a_bench_is_read_is_one_line(forkable, command):
    """msgspec crashes when an exception comes out of a type that it looks at."""
    program = """\
import os, signal, sys
import msgspec
from hilbench.__main__ import main

convert = msgspec.convert
msgspec.convert = lambda *a, **b: (os.kill(os.getpid(), signal.SIGINT), convert(*a, **b))[1]
sys.exit(main())
"""
    done = forkable.run(*command.split(), program=program)
    assert (done.returncode, done.output, done.error) == (130, "", "hilbench: interrupted\n")


def test_an_interruption_that_was_in_an_exec_is_130(run):
    program = """\
import sys
import hilbench.cli, hilbench.__main__

def main():
    try:
        exec("raise KeyboardInterrupt")
    except KeyboardInterrupt:
        return 130

hilbench.cli.main = main
sys.exit(hilbench.__main__.main())
"""
    assert run([], command=[sys.executable, "-c", program]).returncode == 130


@pytest.mark.parametrize("command", [PROCESS, [sys.executable, "-m", "hilbench"]], ids=["script", "python -m"])
def test_the_process_is_the_command(run, command):
    done = run(["validate", "pionere"], command=command)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "hilbench: pionere: no such bench; did you mean 'pioneer'?\n"


def test_the_command_of_the_package_is_the_process():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["scripts"] == {"hilbench": "hilbench.__main__:main"}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_reports_what_was_run_and_what_was_not(forkable, tmp_path, number):
    os.mkfifo(tmp_path / "reached")
    slow = f"""
@my("A2")
def test_b():
    import signal
    with open({str(tmp_path / "reached")!r}, "w") as fifo:
        fifo.write("here")
    signal.pause()

@my("A3")
def test_c(): pass
"""
    words = ["check", "pioneer-plane", "--suite", panel(tmp_path, slow), "--json", "r.json", "--junit", "r.xml"]
    with forkable.start(*words, cwd=tmp_path, stdout=subprocess.PIPE) as process:
        with (tmp_path / "reached").open() as fifo:
            fifo.read()
        process.send_signal(number)
        out, err = process.communicate()
    assert err == "1/3 pass A1 panel/a\n"
    report = json.loads((tmp_path / "r.json").read_text())
    assert process.returncode == report["exit_code"] == 130
    assert [case["verdict"] for case in report["cases"]] == ["pass", "not-run", "not-run"]
    assert "stopped: interrupted; 2 cases not run" in out
    assert ElementTree.parse(tmp_path / "r.xml").getroot().get("tests") == "3"


def test_a_log_has_a_line_for_each_case_as_it_ends(forkable, tmp_path):
    """The second case waits for us, who have read of the first by then."""
    os.mkfifo(tmp_path / "reached")
    more = f"""
@my("A2")
def test_b():
    open({str(tmp_path / "reached")!r}).read()
    assert False, "no answer"
"""
    with forkable.start("check", "pioneer-plane", "--suite", panel(tmp_path, more), stdout=subprocess.PIPE) as process:
        process.hear("1/2 pass A1 panel/a")
        (tmp_path / "reached").write_text("go on")
        out, err = process.communicate()
    assert err == "2/2 fail A2 panel/b: no answer\n"
    assert out.startswith("hilbench ")
    assert process.returncode == 1


def test_a_log_that_nobody_reads_does_not_stop_the_run(forkable, tmp_path):
    read, write = os.pipe()
    os.set_blocking(write, False)
    with contextlib.suppress(BlockingIOError):
        while os.write(write, b"x" * 4096):
            pass
    os.set_blocking(write, True)
    done = forkable.run("check", "pioneer-plane", "--suite", panel(tmp_path), stderr=write)
    assert (done.returncode, done.output.splitlines()[-1]) == (0, "exit 0: all checks passed")
    os.close(write)
    os.close(read)


def test_piped_output_has_no_colours_and_no_progress(forkable, tmp_path):
    words = ["check", "pioneer-plane", "--suite", panel(tmp_path)]
    done = forkable.run(*words, env={"FORCE_COLOR": "1", "CLICOLOR_FORCE": "1"})
    assert done.returncode == 0
    assert "\x1b" not in done.output
    assert done.error == CASE_ENDED


@pytest.mark.parametrize(("no_color", "coloured"), [("", True), ("1", False)])
def test_a_terminal_has_colours_unless_told_otherwise(forkable, tmp_path, no_color, coloured):
    controller, terminal = os.openpty()
    environment = {"TERM": "xterm", "NO_COLOR": no_color}
    words = ["check", "pioneer-plane", "--suite", panel(tmp_path)]
    with forkable.start(*words, env=environment, stdout=terminal, stderr=terminal) as process:
        os.close(terminal)
        text = b""
        while chunk := _read(controller):
            text += chunk
        process.wait()
    os.close(controller)
    assert process.returncode == 0
    assert (b"\x1b[32mpass\x1b[0m" in text) is coloured
    assert b"\r\x1b[K1/1 A1 panel/a" in text


def _read(descriptor):
    try:
        return os.read(descriptor, 4096)
    except OSError:  # the other end is closed: EIO on Linux
        return b""


# A project that gets in the way.


@pytest.fixture
def hostile(tmp_path):
    """Everything a user's project can have that reaches a pytest run, all of it harmful."""
    folder = tmp_path / "hostile"
    bad = "raise SystemExit('the project reached into the check')\n"
    for name in ("protocols", "targets", "worlds", "tests"):
        (folder / name).mkdir(parents=True)
        (folder / name / "__init__.py").write_text(bad)
    (folder / "conftest.py").write_text(bad)
    (folder / "tests" / "conftest.py").write_text(bad)
    (folder / "pytest.ini").write_text("[pytest]\naddopts = --no-such-option -p no:python\ntestpaths = nowhere\n")
    (folder / "tox.ini").write_text("[pytest]\naddopts = --no-such-option\n")
    (folder / "pyproject.toml").write_text('[tool.pytest.ini_options]\naddopts = "--no-such-option"\n')
    (folder / "random_order.py").write_text(
        "import pytest\n"
        "@pytest.hookimpl(trylast=True)\n"
        "def pytest_collection_modifyitems(items):\n    items.reverse()\n"
    )
    return folder


HOSTILE_ENVIRONMENT = {
    "PYTEST_PLUGINS": "random_order",
    "PYTEST_ADDOPTS": "--no-such-option -p random_order --maxfail=1",
    "PYTEST_THEME": "no-such-theme",
}


def hashes(report):
    return [(case["id"], case["verdict"], case["case_hash"]) for case in report["cases"]]


@pytest.mark.parametrize(
    "command",
    [
        HILBENCH,
        pytest.param(
            [sys.executable, "-m", "hilbench"],
            marks=pytest.mark.exhaustive("the gate runs python -m there with a suite of the user's own"),
        ),
    ],
    ids=["script", "python -m"],
)
def test_a_hostile_project_does_not_disturb_a_check(run, hostile, tmp_path, capfd, command):
    words = ["check", "pioneer-plane", "--suite", "p2os-server", "-k", "S01 or S02 or S03", "--json", "-"]
    assert main(words) == 0
    expected = capfd.readouterr().out
    # the plugin is importable for pytest, the packages are not shadowed: that is the next test
    (tmp_path / "plugins").mkdir()
    (hostile / "random_order.py").rename(tmp_path / "plugins" / "random_order.py")
    found = run(
        words,
        command=_without_safe_path(command),
        cwd=hostile,
        env={**HOSTILE_ENVIRONMENT, "PYTHONPATH": str(tmp_path / "plugins")},
    )
    assert found.returncode == 0, found.stderr
    assert hashes(json.loads(found.stdout)) == hashes(json.loads(expected))


def _without_safe_path(command):
    """Return the command as an installed script behaves: without the working folder on ``sys.path``."""
    return [command[0], "-P", *command[1:]] if "-c" in command else command


@pytest.mark.parametrize("command", [HILBENCH, [sys.executable, "-m", "hilbench"]], ids=["script", "python -m"])
def test_a_package_that_takes_the_place_of_ours_is_named(run, hostile, command):
    done = run(
        ["check", "pioneer-plane"], command=_without_safe_path(command), cwd=hostile, env={"PYTHONPATH": str(hostile)}
    )
    assert done.returncode == 3
    assert done.stdout == ""
    assert done.stderr.startswith(f"hilbench: {hostile}/protocols: shadows the package 'protocols' of hilbench")
    assert done.stderr.count("\n") == 1


def test_a_user_s_own_suite_finds_its_way_in_from_a_hostile_project(run, hostile):
    suite = panel(hostile)
    done = run(["check", "pioneer-plane", "--suite", suite], command=[sys.executable, "-m", "hilbench"], cwd=hostile)
    assert done.returncode == 0, done.stderr


# Plain pytest.

OWN = """
import pytest
from hilbench.check import case

@case("S01")
def test_sync0(peer):
    peer.write(bytes.fromhex("FAFB03000000"))

@case("X1", text="It flies.", needs=("wings",))
def test_flies(bench): pass

def test_plain(): pass

@case("X2", text="It fails.")
def test_fails(bench):
    assert 1 == 2
"""


def test_plain_pytest_has_the_fixtures(forkable, tmp_path):
    (tmp_path / "test_own.py").write_text(OWN)
    words = ["-q", "-rs", "-p", "no:cacheprovider", "-p", "hilbench.pytest_plugin", "--hilbench-bench", "pioneer-plane"]
    done = forkable.run(*words, program=PYTEST, cwd=tmp_path)
    assert "1 failed, 2 passed, 1 skipped" in done.output, done.output + done.error
    assert "not applicable: no wings" in done.output
    assert done.returncode == 1


WITHOUT_PHYSICS = f"import sys\nsys.modules['pybullet'] = sys.modules['mujoco'] = None\n{PYTEST}"


def plain_pytest_without_physics(forkable, folder, clause, *words):
    text = f"from hilbench.check import case\n\n@case({clause!r})\ndef test_a(peer): pass\n\ndef test_plain(): pass\n"
    (folder / "test_own.py").write_text(text)
    more = ["-q", "-p", "no:cacheprovider", "-p", "hilbench.pytest_plugin", "--hilbench-bench", "pioneer"]
    return forkable.run(*more, *words, program=WITHOUT_PHYSICS, cwd=folder)


@pytest.mark.parametrize(
    ("clause", "code", "why"),
    [("NOSUCH1", 2, "'NOSUCH1', which no catalogue holds"), ("S01", 3, "MuJoCo is not installed")],
)
def test_plain_pytest_says_why_it_runs_nothing(forkable, tmp_path, clause, code, why):
    done = plain_pytest_without_physics(forkable, tmp_path, clause)
    assert done.returncode == code, done.output + done.error
    assert why in done.output + done.error


@pytest.mark.parametrize(
    ("words", "said"), [(["--collect-only"], "2 tests collected"), (["-k", "plain"], "1 passed, 1 deselected")]
)
def test_plain_pytest_misses_no_physics_for_what_does_not_run(forkable, tmp_path, words, said):
    done = plain_pytest_without_physics(forkable, tmp_path, "S01", *words)
    assert done.returncode == 0, done.output + done.error
    assert said in done.output


def test_plain_pytest_in_a_folder_with_packages_of_our_names_stops_in_one_line(run, hostile):
    for file in (*hostile.glob("*.*"), hostile / "tests" / "conftest.py"):
        file.unlink()
    (hostile / "test_own.py").write_text(OWN)
    done = run(["-q", "-p", "hilbench.pytest_plugin"], command=[sys.executable, "-m", "pytest"], cwd=hostile)
    assert done.returncode == 3
    lines = [line for line in (done.stdout + done.stderr).splitlines() if line]
    assert len(lines) == 1
    assert f"{hostile}/protocols: shadows the package 'protocols' of hilbench" in lines[0]
