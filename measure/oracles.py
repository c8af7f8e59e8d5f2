"""``python -m measure.oracles``: our cores beside Unicorn and the definition of floating point, as long as one likes.

Random sequences of instructions (tests/targets/mcu/differential) run whole, cut at random and on Unicorn, images of 200
at a time; each floating-point operation runs over random operands on our core, on Unicorn and by exact arithmetic. What
was compared is appended to a file as soon as it is there: a later call with the same sources of the core goes on where
that ends. Differences are printed with what is needed to see one alone; those by a known error of Unicorn are only
counted. The exit code is 0 when all that was asked for was compared and nothing differs otherwise.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from targets.mcu.core.sources import digest_of
from tests.targets.mcu.differential import float_oracle, oracle
from tests.targets.mcu.differential.image import CASES

OUT = Path(__file__).parent.parent / "out" / "oracles"
SEED = 1000
IMAGES, OPERANDS = 50, 20_000  # that a process compares before it tells

Job = tuple[str, int]


def batch(job: Job) -> dict[str, Any]:
    """Compare one piece: of a core, from an image number on, or of an operation, from an operand on."""
    what, start = job
    count, problems, excused = 0, [], Counter[str]()
    if what in oracle.KINDS:
        for image in range(start, start + IMAGES):
            compared = oracle.compare(what, SEED, image * CASES)
            count += compared.sequences
            problems += compared.problems
            excused.update(compared.excused)
    else:
        operation = float_oracle.BY_NAME[what]
        count = OPERANDS
        operands = float_oracle.random_operands(operation, random.Random(f"{SEED}: {what}: {start}"), count)
        problems = float_oracle.problems(operation, operands, by_definition=True, by_unicorn=True)
    return {"what": what, "start": start, "count": count, "problems": problems, "excused": dict(excused)}


def jobs(models: Sequence[str], sequences: int, operands: int, done: set[Job]) -> Iterator[Job]:
    """Return what is still to do, as arguments of `batch`."""
    wanted = [(model, start) for model in models for start in range(0, -(-sequences // CASES), IMAGES)]
    # piece by piece of all operations, so that an early end has some of each
    wanted += [(name, start) for start in range(0, operands, OPERANDS) for name in float_oracle.BY_NAME]
    return (job for job in wanted if job not in done)


def kept(path: Path) -> list[dict[str, Any]]:
    """Return what earlier calls have found."""
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m measure.oracles", description="Compare our cores with others.")
    million = 1_000_000
    parser.add_argument("--sequences", type=int, default=million, help="of each core (default: %(default)s)")
    parser.add_argument("--operands", type=int, default=million, help="of each operation (default: %(default)s)")
    parser.add_argument("--core", choices=[*oracle.KINDS], action="append", help="for sequences (default: both)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: %(default)s)")
    parser.add_argument("--out", type=Path, default=OUT, help="folder of the results (default: %(default)s)")
    options = parser.parse_args(arguments)
    if not oracle.version():
        sys.stderr.write("measure.oracles: Unicorn is not installed: pip install -e '.[dev]'\n")
        return 3
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / f"unicorn-{oracle.version()}-{digest_of()[:12]}.jsonl"
    results = kept(path)
    for result in results:
        tell(result)
    done = {(result["what"], result["start"]) for result in results}
    todo = list(jobs(options.core or [*oracle.KINDS], options.sequences, options.operands, done))
    with ProcessPoolExecutor(options.jobs) as processes, path.open("a") as file:
        for result in processes.map(batch, todo):
            results.append(result)
            file.write(json.dumps(result) + "\n")
            file.flush()
            tell(result)
    return summary(results)


def tell(result: dict[str, Any]) -> None:
    """Print what differs."""
    for problem in result["problems"]:
        sys.stdout.write(f"{result['what']}: {problem}\n\n")
    sys.stdout.flush()


def summary(results: Sequence[dict[str, Any]]) -> int:
    """Print what came of all; return the exit code."""
    counts, different, excused = Counter[str](), Counter[str](), Counter[str]()
    for result in results:
        counts[result["what"]] += result["count"]
        different[result["what"]] += len(result["problems"])
        excused.update(result["excused"])
    for what, count in counts.items():
        unit = "sequences" if what in oracle.KINDS else "operands"
        sys.stdout.write(f"{what}: {count} {unit}, {different[what]} differ\n")
    for name, known in oracle.KNOWN.items():
        sys.stdout.write(f"known of Unicorn, {excused[name]} sequences: {known.text}\n")
    return 1 if different.total() else 0


if __name__ == "__main__":
    sys.exit(main())
