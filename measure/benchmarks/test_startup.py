"""How long ``hilbench --help`` takes, held against a bare interpreter; `make bench` prints it.

It is meant to stay under 0.2 s; nothing is asserted on time. What keeps it there, the imports that are put off, is
tested with the packages.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time

RUNS = 7


def median_s(program):
    """Median over several processes, after one that warms the page cache."""
    times_s = []
    for _ in range(RUNS + 1):
        began_s = time.perf_counter()
        subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.DEVNULL, timeout=30)
        times_s.append(time.perf_counter() - began_s)
    return statistics.median(times_s[1:])


def report(capfd, record_property, command, arguments):
    bare_s, help_s = median_s("pass"), median_s(f"from hilbench.cli import main; main({arguments!r})")
    with capfd.disabled():
        sys.stdout.write(
            f"\n{command}: {help_s * 1000:.0f} ms, python -c pass: {bare_s * 1000:.0f} ms, "
            f"ratio {help_s / bare_s:.1f} (median of {RUNS})\n"
        )
    record_property("ratio", help_s / bare_s)


def test_help_against_a_bare_interpreter(capfd, record_property):
    report(capfd, record_property, "hilbench --help", ["--help"])


def test_the_help_of_a_command_against_a_bare_interpreter(capfd, record_property):
    report(capfd, record_property, "hilbench check --help", ["check", "--help"])
