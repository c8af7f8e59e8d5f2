"""``python -m measure.dashboard_load``: what a dashboard costs a bench whose line is full both ways.

Pairs of runs without and with a dashboard, interleaved; or, with ``--memory``, a bench of one's choice for so many
seconds of bench time, as fast as it goes, with a dashboard that looks at it each second of that time; or, with
``--pictures``, the processor time of each picture of such a bench, with a recorded feed, which a busy machine hardly
changes.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from measure.dashboard_load.measure import Figures, measure
from measure.dashboard_load.memory import watch_memory
from measure.dashboard_load.pictures import cost
from measure.dashboard_load.rig import BAUD, serve
from measure.dashboard_load.screen import attach

_HEAD = "{:<9}{:>10}{:>10}{:>9}{:>7}{:>11}{:>11}{:>12}{:>9}".format(
    "", "p50 ms", "p99 ms", "factor", "slips", "bench CPU", "its CPU", "drawn B/s", "stolen"
)
_ROW = "{:<9}{:>10.3f}{:>10.3f}{:>9.4f}{:>7}{:>11.1%}{:>11.1%}{:>12.0f}{:>9.1%}"


def main(words: Sequence[str]) -> int:
    """Measure, or be one of the processes that are measured."""
    parser = argparse.ArgumentParser(prog="python -m measure.dashboard_load", description=__doc__)
    parser.add_argument("role", nargs="?", choices=("bench", "screen"), help=argparse.SUPPRESS)
    parser.add_argument("of", nargs="?", help=argparse.SUPPRESS)
    parser.add_argument("--pairs", type=int, default=5, help="how many pairs (default: 5)")
    parser.add_argument("--span", type=float, default=15.0, help="seconds of host time each (default: 15)")
    parser.add_argument(
        "--fps", type=int, default=20, help="pictures that the dashboard draws in a second (default: 20)"
    )
    parser.add_argument("--memory", metavar="BENCH", help="watch the memory instead: 'full', or any bench")
    parser.add_argument("--bench-time", type=float, default=3600.0, help="for --memory: seconds (default: 3600)")
    parser.add_argument("--pictures", metavar="BENCH", help="count the cost of pictures instead: 'full', or any bench")
    parser.add_argument("--profile", action="store_true", help="for --pictures: where it goes")
    chosen = parser.parse_args(words)
    if chosen.role == "bench":
        return serve(Path(chosen.of))
    if chosen.role == "screen":
        return attach(chosen.of, chosen.fps)
    if chosen.memory:
        watch_memory(chosen.memory, chosen.bench_time)
        return 0
    if chosen.pictures:
        _say(cost(chosen.pictures, chosen.span, chosen.fps, profiled=chosen.profile))
        return 0
    compare(chosen.pairs, chosen.span, chosen.fps)
    return 0


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def compare(pairs: int, span_s: float, frames_per_s: int) -> None:
    """Measure pairs, the order of each the other way round, and print them."""
    _say(f"{BAUD} baud, full both ways; {span_s:g} s each; {frames_per_s} pictures a second at 200x60")
    _say(f"load average {os.getloadavg()[0]:.1f}, {os.cpu_count()} processors")
    _say(_HEAD)
    found: dict[int, list[Figures]] = {0: [], frames_per_s: []}
    for pair in range(pairs):
        for rate in (0, frames_per_s) if pair % 2 == 0 else (frames_per_s, 0):
            figures = measure(span_s, rate)
            found[rate].append(figures)
            _print("with" if rate else "without", figures)
    _say(f"load average {os.getloadavg()[0]:.1f}")
    for name in ("p50_ms", "p99_ms"):
        without, with_one = ([getattr(one, name) for one in found[rate]] for rate in (0, frames_per_s))
        spread = (min(without), max(without))
        _say(f"{name} without {spread[0]:.3f} to {spread[1]:.3f}, with {min(with_one):.3f} to {max(with_one):.3f}")


def _print(name: str, one: Figures) -> None:
    row = (one.p50_ms, one.p99_ms, one.factor, one.slips, one.bench_cpu, one.screen_cpu, one.drawn_per_s, one.stolen)
    _say(_ROW.format(name, *row))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
