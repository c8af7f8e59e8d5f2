"""The golden traces by hand: `python -m tests.targets.mcu.traces [--write | --print] [NAME ...]`.

Without an option each scenario is run and compared; the exit code says whether all are the same. `--write` writes those
that are not, to be looked at with `git diff` and committed; `--print` writes whole traces to stdout.
"""

from __future__ import annotations

import argparse
import sys

from tests.targets.mcu.traces.goldens import abridged, difference, golden_path, lines_of
from tests.targets.mcu.traces.scenarios import SCENARIOS, trace


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.targets.mcu.traces", description="golden traces")
    choice = parser.add_mutually_exclusive_group()
    choice.add_argument("--write", action="store_true", help="write what differs")
    choice.add_argument("--print", action="store_true", help="write whole traces to stdout")
    parser.add_argument("names", nargs="*", metavar="NAME", help="all if left out")
    options = parser.parse_args()
    unknown = set(options.names) - set(SCENARIOS)
    if unknown:
        parser.error(f"no scenario: {', '.join(sorted(unknown))}; there are: {', '.join(SCENARIOS)}")
    differing = 0
    for name in options.names or SCENARIOS:
        header, lines = trace(SCENARIOS[name])
        if options.print:
            sys.stdout.write("\n".join([*header, *lines, ""]))
            continue
        found = abridged(header, lines)
        what = difference(lines_of(name), found)
        if what:
            differing += 1
            sys.stdout.write(f"{name}: {what}\n")
        if what and options.write:
            golden_path(name).parent.mkdir(exist_ok=True)
            golden_path(name).write_text("\n".join([*found, ""]), encoding="utf-8")
    return 1 if differing and not options.write else 0


if __name__ == "__main__":
    sys.exit(main())
