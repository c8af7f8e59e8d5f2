"""Runs a suite through a door: what is served is a process, so is the proxy, so is the check."""

from __future__ import annotations

import contextlib
import json
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from measure.doors.benches import Served

__all__ = ["run_through"]

_READY = "stop with Ctrl-C"
_PACE = re.compile(
    r"at (?P<factor>[\d.]+) x real time; "
    r"lateness p50 (?P<p50>[\d.]+) ms, p99 (?P<p99>[\d.]+) ms, max (?P<max>[\d.]+) ms, (?P<slips>\d+) slips"
)
"""What `hilbench serve` says of its own host at its end."""
BOOT_S = 3
"""How long firmware has for its start before it is checked, as a board on the desk has had."""
_TCP = re.compile(r"serving (?:(\S+) )?at \w+ 127\.0\.0\.1:(\d+)")
"""A line, where there are several, and the port that leads to it."""
_END_S = 30


def run_through(door: str, served: Served, select: str) -> Mapping[str, Any]:
    """Check a bench through a door; return verdicts by case, and how late the host was.

    Args:
        door: one of `measure.doors.benches.DOORS`.
        served: what.
        select: as ``-k``; empty for all cases.
    """
    words = [served.bench, "--suite", served.suite, "--json", "-"] + (["-k", select] if select else [])
    last_words: list[str] = []
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        if door != "memory":
            for target in stack.enter_context(_targets(door, served, Path(folder), last_words)):
                words += ["--target", target]
        command = [sys.executable, "-m", "hilbench", "check", *words]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    told = _PACE.search(last_words[-1]) if last_words else None
    if not done.stdout.startswith("{"):
        raise RuntimeError(f"{' '.join(words)}: {done.stderr.strip()}")
    report = json.loads(done.stdout)
    return {
        "bench": served.bench,
        "suite": served.suite,
        "door": door,
        "select": select,
        "pace": report["observed"]["pace"],
        "served": None if told is None else {name: float(value) for name, value in told.groupdict().items()},
        "bench_time_s": round(report["bench_time_s"], 1),
        "host_time_s": round(report["host_time_s"], 1),
        "verdicts": {case["id"]: case["verdict"] for case in report["cases"]},
        "causes": {case["id"]: case["cause"] for case in report["cases"] if case["verdict"] not in {"pass", "n/a"}},
    }


@contextlib.contextmanager
def _targets(door: str, served: Served, folder: Path, last_words: list[str]) -> Iterator[Sequence[str]]:
    """Serve each line through a door; yield what ``--target`` takes. What the server says at its end comes last."""
    option = {"tcp": "--tcp", "rfc2217": "--rfc2217"}.get(door, "--pty")
    words = [sys.executable, "-m", "hilbench", "serve", served.bench]
    for number, line in enumerate(served.lines.values()):
        where = "0" if door in {"tcp", "rfc2217"} else f"{folder}/line{number}"
        words += [option, f"{line}={where}" if line else where]
    with contextlib.ExitStack() as stack:
        said = stack.enter_context(_running(words, last_words, BOOT_S))
        ports = dict(_TCP.findall(said))
        targets = []
        for number, (name, line) in enumerate(served.lines.items()):
            place = f"serial:{folder}/line{number}"
            if door == "proxy":
                proxied = f"pty:{folder}/proxied{number}"
                command = [sys.executable, "-m", "hilbench", "proxy", proxied, f"{place}@{served.baud}"]
                stack.enter_context(_running(command, last_words, 0))
                place = f"serial:{folder}/proxied{number}"
            elif door != "pty":
                place = f"{'socket' if door == 'tcp' else 'rfc2217'}://127.0.0.1:{ports[line]}"
            targets.append(f"{name}={place}@{served.baud}" if name else f"{place}@{served.baud}")
        yield targets


@contextlib.contextmanager
def _running(command: Sequence[str], last_words: list[str], boot_s: float) -> Iterator[str]:
    """Run a command that serves; yield what it said until it did, and keep what it says in all."""
    with tempfile.TemporaryFile("w+") as talk:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=talk, stdout=subprocess.DEVNULL)
        try:
            said = _until_ready(process, talk)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(boot_s)
            yield said
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(_END_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            talk.seek(0)
            last_words.append(str(talk.read()))


def _until_ready(process: subprocess.Popen[bytes], talk: Any) -> str:
    while process.poll() is None:
        talk.seek(0)
        said = str(talk.read())
        if _READY in said:
            return said
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(0.1)
    talk.seek(0)
    raise RuntimeError(f"it does not serve: {talk.read()}")
