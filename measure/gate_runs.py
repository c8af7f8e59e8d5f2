"""``python -m measure.gate_runs``: the gate, twelve times, on hosts that make it hard for tests that look at a clock.

Each run is ``make test`` in a clean clone of the last commit: three on an idle host, six beside four busy loops, one on
a single processor, one as root in a folder of mode 0700, one as an ordinary user. Every result is appended to a file as
soon as it is there, so that the runs may be spread over days: what has been run of a commit is not run again. A run
that failed keeps its output. The exit code is 0 when all runs of the commit are there and none has failed.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import pwd
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from hilbench.clock import Stopwatch, wall_time_iso
from measure.appended import read

ROOT = Path(__file__).parent.parent
OUT = ROOT / "out" / "gate-runs"
BUSY_LOOPS = 4
USER = "hilbench-gate"


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """What a run of the gate has to bear.

    Attributes:
        name: what the results call it.
        times: how many runs of it are asked for.
        busy: programs that only burn time run beside it.
        single: it gets one processor.
        private: the clone lies in a folder that nobody but its owner may enter.
        user: it is run by an ordinary user.
    """

    name: str
    times: int = 1
    busy: bool = False
    single: bool = False
    private: bool = False
    user: bool = False


CONDITIONS = (
    Condition(name="idle", times=3),
    Condition(name="folder-0700", private=True),
    Condition(name="ordinary-user", user=True),
    Condition(name="one-processor", single=True),
    Condition(name="busy", times=6, busy=True),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What came of a run: times in seconds, what pytest said last, and the tests that failed."""

    commit: str
    condition: str
    when: str
    exit_code: int
    wall_s: float
    cpu_s: float
    summary: str
    failed: tuple[str, ...] = ()


def git(*arguments: str) -> str:
    """Return what git says of this checkout."""
    return subprocess.run(
        ["git", "-C", str(ROOT), *arguments], check=True, capture_output=True, text=True
    ).stdout.strip()


@contextlib.contextmanager
def busy_loops(number: int) -> Iterator[None]:
    """Keep the processors busy meanwhile."""
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(number)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def account() -> pwd.struct_passwd:
    """Return the ordinary user that runs the gate; make it if there is none.

    Raises:
        OSError: only root can.
    """
    try:
        return pwd.getpwnam(USER)
    except KeyError:
        subprocess.run(["useradd", "--create-home", "--shell", "/bin/bash", USER], check=True)
        return pwd.getpwnam(USER)


@contextlib.contextmanager
def clone(condition: Condition) -> Iterator[Path]:
    """Make a clean clone of the last commit where the condition wants it; nothing of it remains."""
    home = Path(account().pw_dir) if condition.user else Path.home() if condition.private else None
    folder = Path(tempfile.mkdtemp(prefix="gate-run-", dir=home))
    try:
        folder.chmod(0o700 if condition.private or condition.user else 0o755)
        checkout = folder / "hilbench"
        git("clone", "--quiet", "--no-hardlinks", str(ROOT), str(checkout))
        if condition.private:
            checkout.chmod(0o700)
        if condition.user:
            subprocess.run(["chown", "-R", f"{USER}:", str(folder)], check=True)
        yield checkout
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def temporary_files() -> Iterator[dict[str, str]]:
    """Yield an environment with a place for temporary files like /tmp: pytest would clear up after older runs there."""
    with tempfile.TemporaryDirectory(prefix="gate-run-tmp-", ignore_cleanup_errors=True) as folder:
        Path(folder).chmod(0o1777)
        yield {**os.environ, "TMPDIR": folder}


def run(condition: Condition, commit: str, log: Path) -> Result:
    """Run the gate once; what it prints goes to a file."""
    command = ["make", "test"]
    if condition.single:
        command = ["taskset", "--cpu-list", str(min(os.sched_getaffinity(0))), *command]
    if condition.user:
        command = ["runuser", "--user", USER, "--", "env", f"HOME={account().pw_dir}", *command]
    loops = busy_loops(BUSY_LOOPS) if condition.busy else contextlib.nullcontext()
    with clone(condition) as checkout, temporary_files() as environment, log.open("wb") as printed, loops:
        watch = Stopwatch()
        process = subprocess.Popen(
            command,
            cwd=checkout,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=printed,
            stderr=subprocess.STDOUT,
        )
        try:
            _, status, used = os.wait4(process.pid, 0)
        except KeyboardInterrupt:
            process.wait()
            raise
        process.returncode = os.waitstatus_to_exitcode(status)
        wall_s = watch.elapsed_s()
    text = log.read_text(encoding="utf-8", errors="replace")
    return Result(
        commit=commit,
        condition=condition.name,
        when=wall_time_iso(),
        exit_code=process.returncode,
        wall_s=round(wall_s, 1),
        cpu_s=round(used.ru_utime + used.ru_stime, 1),
        summary=next(
            iter(re.findall(r"^=*\s*(\d+ (?:passed|failed).* in [\d.]+s.*?)\s*=*$", text, re.MULTILINE)[-1:]), ""
        ),
        failed=tuple(re.findall(r"^(?:FAILED|ERROR) (\S+)", text, re.MULTILINE)),
    )


def table(found: Sequence[Result]) -> str:
    """Return the results as a table in Markdown."""
    rows = ["| run | exit | wall s | processor s | pytest |", "|---|---|---|---|---|"]
    rows += [f"| {one.condition} | {one.exit_code} | {one.wall_s} | {one.cpu_s} | {one.summary} |" for one in found]
    rows += [f"\n{one.condition} failed: {test}" for one in found for test in one.failed]
    return "\n".join(rows) + "\n"


def missing(found: Sequence[Result], names: Sequence[str]) -> list[Condition]:
    """Return the runs that are still to be made, in order."""
    done = [one.condition for one in found]
    return [
        condition
        for condition in CONDITIONS
        if not names or condition.name in names
        for _ in range(condition.times - done.count(condition.name))
    ]


def main() -> int:
    """Make the runs that are missing, and print what there is of the last commit."""
    parser = argparse.ArgumentParser(
        prog="python -m measure.gate_runs", description="the gate, twelve times, where it is hard for it"
    )
    parser.add_argument("--report", action="store_true", help="print what has been run of the last commit, run nothing")
    parser.add_argument(
        "--out", type=Path, default=OUT, help="where results and logs are kept (default: out/gate-runs)"
    )
    choices = [condition.name for condition in CONDITIONS]
    parser.add_argument("conditions", nargs="*", metavar="CONDITION", help=f"all if left out: {', '.join(choices)}")
    options = parser.parse_args()
    if unknown := set(options.conditions) - set(choices):
        parser.error(f"no condition: {', '.join(sorted(unknown))}; there are: {', '.join(choices)}")
    options.out.mkdir(parents=True, exist_ok=True)
    file, commit = options.out / "results.jsonl", git("rev-parse", "--short=10", "HEAD")
    found = [one for one in read(file, Result) if one.commit == commit]
    todo = [] if options.report else missing(found, options.conditions)
    if os.geteuid() != 0 and any(condition.user for condition in todo):
        sys.stderr.write("ordinary-user is left out: only root can become another user\n")
        todo = [condition for condition in todo if not condition.user]
    for number, condition in enumerate(todo, 1):
        sys.stderr.write(f"{number}/{len(todo)} {condition.name} ...\n")
        log = options.out / f"{commit}-{condition.name}-{wall_time_iso().replace(':', '')}.log"
        one = run(condition, commit, log)
        with file.open("a", encoding="utf-8") as results_file:
            results_file.write(json.dumps(asdict(one)) + "\n")
        sys.stderr.write(f"  exit {one.exit_code}, {one.wall_s} s, processor {one.cpu_s} s: {one.summary}\n")
        if one.exit_code == 0:
            log.unlink()
        found.append(one)
    sys.stdout.write(table(found))
    return 1 if any(one.exit_code for one in found) or missing(found, []) else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.stderr.write("interrupted; what was run is kept\n")
        sys.exit(130)
