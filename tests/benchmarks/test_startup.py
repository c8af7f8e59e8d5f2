"""How long ``hilbench --help`` takes, held against a bare interpreter; `make bench` prints it."""

from __future__ import annotations

import statistics
import subprocess
import sys
import time

RUNS = 7
LIMIT_S = 0.2


def median_s(program):
    """Median over several processes, after one that warms the page cache."""
    times_s = []
    for _ in range(RUNS + 1):
        began_s = time.perf_counter()
        subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.DEVNULL, timeout=30)
        times_s.append(time.perf_counter() - began_s)
    return statistics.median(times_s[1:])


def report(capfd, command, arguments):
    bare_s, help_s = median_s("pass"), median_s(f"from hilbench.cli import main; main({arguments!r})")
    with capfd.disabled():
        sys.stdout.write(
            f"\n{command}: {help_s * 1000:.0f} ms, python -c pass: {bare_s * 1000:.0f} ms, "
            f"ratio {help_s / bare_s:.1f} (median of {RUNS})\n"
        )
    return help_s


def test_help_against_a_bare_interpreter(capfd):
    assert report(capfd, "hilbench --help", ["--help"]) < LIMIT_S


def test_the_help_of_a_command_against_a_bare_interpreter(capfd):
    assert report(capfd, "hilbench check --help", ["check", "--help"]) < LIMIT_S
