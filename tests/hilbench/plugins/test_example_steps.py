"""The examples as their pages say: each line of the first block is run, in this order, with what pip has installed."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import select
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[3] / "examples"
PATIENCE_S = 600
STEPS = {
    name: [
        line.partition("  #")[0].strip()
        for line in re.search(r"```\n(.*?)```", (EXAMPLES / name / "README.md").read_text(), re.DOTALL)[1].splitlines()
    ]
    for name in ("pantilt", "tank")
}
NO_FAIL, JUDGED = {0, 4}, {0, 1, 4}
"""Exit codes in bench time, and at a port: there a host that others use may be late, and no verdict is tested."""


class Shell:
    """Runs the lines of a page: where a port of hardware is named, what is served at a pty stands there."""

    def __init__(self, example, folder):
        self.folder, self.site = folder, folder / "site"
        self.example, self.cwd = example, folder
        self.environment = {**os.environ, "PYTHONPATH": str(self.site), "XDG_RUNTIME_DIR": str(folder)}
        self.environment |= {"TERM": "xterm-256color", "XDG_STATE_HOME": str(folder / "state")}
        self.served = contextlib.ExitStack()

    def do(self, step):
        """Do what a line says; return the exit code."""
        match shlex.split(step):
            case ["pip", "install", _]:
                how = ["--quiet", "--no-index", "--no-deps", "--no-build-isolation", "--target", self.site]
                words = [sys.executable, "-m", "pip", "install", *how, self.example]
                return subprocess.run(words, check=False).returncode
            case ["cd", _]:
                self.cwd = self.example
                return 0
            case ["hilbench", "serve", *_] as words:
                self.served.enter_context(self.serve(words[1:], self.folder))
                return 0
            case ["hilbench", bench] if bench.endswith(".toml") or bench == self.example.name:
                return self.look(bench)
            case ["hilbench", *words]:
                return self.check_or_decode(words)
        raise AssertionError(f"nobody knows how to do: {step}")

    def check_or_decode(self, words):
        """Run a command to its end; what is to be at hardware's port is served by the emulated board meanwhile."""
        with contextlib.ExitStack() as until:
            if "serial:/dev/ttyUSB0" in words:
                until.enter_context(self.serve(["serve", words[1], "--pty", "usart1=./board"], self.folder))
                words = [word.replace("/dev/ttyUSB0", "./board") for word in words]
            words = [re.sub(r"^(serial|capture):(?!/)", rf"\1:{self.folder}/", word) for word in words]
            words = [str(self.folder / word) if word.endswith(".jsonl") and ":" not in word else word for word in words]
            done = subprocess.run(
                self.command(words), cwd=self.cwd, env=self.environment, capture_output=True, text=True
            )
        return done.returncode

    @contextlib.contextmanager
    def serve(self, words, folder):
        words = [re.sub(r"(^|=)\./", rf"\1{folder}/", word) for word in words]
        with subprocess.Popen(
            self.command(words), cwd=self.cwd, env=self.environment, stderr=subprocess.PIPE, text=True
        ) as process:
            assert any("stop with" in line for line in process.stderr)
            yield
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE_S) == 0

    def look(self, bench):
        """Open the dashboard in a terminal, and stop the bench when its frames are shown."""
        outside, inside = pty.openpty()
        streams = {"stdin": inside, "stdout": inside, "stderr": inside, "start_new_session": True}
        environment = self.environment | {"COLUMNS": "160", "LINES": "50"}
        with subprocess.Popen(self.command([bench]), cwd=self.cwd, env=environment, **streams) as process:
            os.close(inside)
            for awaited, keys in (("Read", b"q"), ("Leave it how?", b"s")):
                seen = ""
                while awaited not in seen:
                    assert select.select((outside,), (), (), PATIENCE_S)[0], seen[-2000:]
                    seen += os.read(outside, 65536).decode(errors="replace")
                os.write(outside, keys)
            with contextlib.suppress(OSError):
                while os.read(outside, 65536):
                    pass
            os.close(outside)
            return process.wait(PATIENCE_S)

    def command(self, words):
        return [sys.executable, "-P", "-m", "hilbench", *words]


@pytest.fixture
def shell(tmp_path, request):
    made = Shell(EXAMPLES / request.param, tmp_path)
    with made.served:
        yield made


@pytest.mark.needs_physics
@pytest.mark.exhaustive("half a minute in real time: suites at a port, and dashboards in a terminal")
@pytest.mark.parametrize("shell", STEPS, indirect=True)
def test_each_line_of_the_page_is_done(shell):
    codes = {step: shell.do(step) for step in STEPS[shell.example.name]}
    decoded = [step for step in codes if step.startswith("hilbench decode")]
    assert [codes.pop(step) for step in decoded] == [1]  # the checker sent what makes no sense
    wrong = {step for step, code in codes.items() if code not in (JUDGED if "serial:" in step else NO_FAIL)}
    assert wrong == set(), codes
