"""``python -m measure.right_peers``: right peers are checked again and again; no clause may accuse one.

Three kinds: the model, the real firmware on an emulated board, and a script that shares no code with the project. Each
is checked 90 times in memory and virtual time, each time with another seed, and ten times over a pty in real time, five
of these beside four busy loops. A result is appended to a file as soon as it is there, so that the runs may be spread
over days: what has been run of a commit is not run again. The exit code is 0 when all runs of the commit are there,
none has a failure, and at most one case in a hundred was inconclusive.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import patch

from hilbench.bench import Bench
from hilbench.bench.served_targets import ServedTarget
from hilbench.benchfile.reader import open_bench
from hilbench.check.bench_provider import make_provider
from hilbench.check.runner import run_suites
from hilbench.clock import NS_PER_S, Entry
from hilbench.judging.provider import BenchProvider
from hilbench.judging.verdicts import Verdict
from hilbench.links import Port
from hilbench.protocol_bench.system import system_of
from hilbench.terminal.options import CheckOptions
from measure.appended import read
from measure.gate_runs import BUSY_LOOPS, busy_loops, git
from measure.mutants.derived.subjects import SUBJECTS, Subject, opened
from measure.right_peers.at_port import LINES, PEERS

ROOT = Path(__file__).parents[2]
OUT = ROOT / "out" / "right-peers"
TIMES = {"memory": 90, "pty": 5, "busy": 5}
"""How often, by where."""
MOST_INCONCLUSIVE = 0.01
_GOOD = {Verdict.PASS.value, Verdict.NOT_APPLICABLE.value}


@dataclass(frozen=True, slots=True, kw_only=True)
class RightPeer:
    """Somebody who does everything right.

    Attributes:
        kind: ``model``, ``firmware`` or ``script``.
        protocol: what it speaks.
        subject: the suites that judge it, and the bench that they run on.
        firmware: the bench of its emulated board, if it has one.
        usarts: where `serve` has its lines, as ``NAME=``; empty for the only one.
    """

    kind: str
    protocol: str
    subject: Subject
    firmware: str = ""
    usarts: tuple[str, ...] = ("",)

    @property
    def name(self) -> str:
        """What a command line calls it."""
        return f"{self.kind}-{self.protocol}"


_BOTH = ("usart2=", "usart3=")
RIGHT = {
    peer.name: peer
    for peer in (
        RightPeer(kind="model", protocol="p2os", subject=SUBJECTS["p2os-server"]),
        RightPeer(kind="script", protocol="p2os", subject=SUBJECTS["p2os-server"]),
        RightPeer(kind="model", protocol="pkt", subject=SUBJECTS["pkt-board"]),
        RightPeer(kind="firmware", protocol="pkt", subject=SUBJECTS["pkt-board"], firmware="rover"),
        RightPeer(kind="script", protocol="pkt", subject=SUBJECTS["pkt-board"]),
        RightPeer(kind="model", protocol="carla", subject=SUBJECTS["carla-board"], usarts=_BOTH),
        RightPeer(kind="firmware", protocol="carla", subject=SUBJECTS["carla-board"], firmware="vehicle", usarts=_BOTH),
        RightPeer(kind="script", protocol="carla", subject=SUBJECTS["carla-board"], usarts=_BOTH),
    )
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """What came of checking a peer once.

    Attributes:
        commit: of the project.
        peer: which.
        where: ``memory``, ``pty`` or ``busy``.
        seed: of the check.
        verdicts: how many cases have each.
        accused: of those that failed or broke, the case and its cause; in real time of inconclusive ones, too.
    """

    commit: str
    peer: str
    where: str
    seed: int
    verdicts: dict[str, int]
    accused: dict[str, str] = field(default_factory=dict)


class _Script:
    """A script at the far ends of its lines, in bench time."""

    def __init__(self, bench: Bench, ports: Mapping[str, Port], protocol: str) -> None:
        self._bench, self._ports = bench, dict(zip(LINES[protocol], ports.values(), strict=True))
        self._peer = PEERS[protocol](bench.now_ns / NS_PER_S)
        for line, port in self._ports.items():
            port.on_receive = partial(self._hear, line)
        self._entry: Entry | None = None
        self._wait()

    def _hear(self, line: str, data: bytes, at_ns: int) -> None:
        self._say(self._peer.feed(line, data, at_ns / NS_PER_S))
        self._wait()

    def _say(self, said: Mapping[str, bytes]) -> None:
        for line, data in said.items():
            if data:
                self._ports[line].write(data)

    def _wait(self) -> None:
        at_ns = max(self._bench.now_ns + 1, math.ceil(self._peer.next_s * NS_PER_S))
        if self._entry is not None and self._entry.pending:
            if self._entry.when_ns == at_ns:
                return
            self._bench.scheduler.cancel(self._entry)
        self._entry = self._bench.scheduler.at(at_ns, self._due, source="script")

    def _due(self) -> None:
        self._say(self._peer.poll(self._bench.now_ns / NS_PER_S))
        self._wait()


@contextlib.contextmanager
def in_memory(peer: RightPeer, options: CheckOptions) -> Iterator[BenchProvider]:
    """Return who opens benches with a peer in virtual time: firmware with its world, others at a port."""
    if peer.firmware:
        provider = make_provider(options)
        yield provider
        provider.close()
        return
    bench_file = open_bench(peer.subject.bench)
    assert bench_file.model is not None
    system = system_of(bench_file.model)
    lines = system.served(bench_file, scene=None, baud=None, seed=0).lines

    def make(bench: Bench, ports: Any) -> Any:
        _Script(bench, ports, peer.protocol)
        return lambda: None

    served = patch.object(type(system), "served", lambda *_args, **_options: ServedTarget(lines, make))
    right = opened(peer.subject, lambda _scheduler, port: port, at_port=True)
    with served if peer.kind == "script" else contextlib.nullcontext(), right as provider:
        yield provider


def checked_in_memory(peer: RightPeer, seed: int, also: str = "") -> tuple[dict[str, int], dict[str, str]]:
    """Check a peer once in virtual time, by all cases or some; return the verdicts, and what accuses it."""
    bench, select = peer.firmware or peer.subject.bench, peer.subject.selects(also)
    options = CheckOptions(bench=bench, suites=peer.subject.suites, select=select, seed=seed)
    with in_memory(peer, options) as provider:
        cases = run_suites(options, provider).cases
    return verdicts_of([{"verdict": case.verdict.value, "id": case.id, "cause": case.cause} for case in cases])


def verdicts_of(cases: Sequence[dict[str, Any]]) -> tuple[dict[str, int], dict[str, str]]:
    """Return how many cases have each verdict, and the causes of those that are neither passed nor not applicable."""
    return (
        dict(Counter(case["verdict"] for case in cases)),
        {case["id"]: case["cause"] for case in cases if case["verdict"] not in _GOOD},
    )


@contextlib.contextmanager
def at_pty(peer: RightPeer, folder: Path) -> Iterator[list[str]]:
    """Yield the ptys of a peer that runs in a process of its own, in real time, one for each of its lines."""
    paths = [str(folder / (line or "line")) for line in LINES[peer.protocol]]
    words = ["measure.right_peers.at_port", peer.protocol]
    if peer.kind != "script":
        doors = [f"{usart}{path}" for usart, path in zip(peer.usarts, paths, strict=True)]
        words = ["hilbench", "serve", peer.firmware or peer.subject.bench, *(f"--pty={door}" for door in doors)]
    process = subprocess.Popen([sys.executable, "-m", *words], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        said = process.stdout.readline().split()
        yield said if peer.kind == "script" else paths
    finally:
        process.terminate()
        process.wait()
        process.stdout.close()


def checked_at_pty(peer: RightPeer, seed: int) -> tuple[dict[str, int], dict[str, str]]:
    """Check a peer once over ptys; return the verdicts, and what accuses it."""
    with tempfile.TemporaryDirectory() as folder, at_pty(peer, Path(folder)) as paths:
        report = Path(folder) / "report.json"
        words = ["check", peer.subject.bench, "--seed", str(seed), "-q", "--json", str(report)]
        for line, path in zip(LINES[peer.protocol], paths, strict=True):
            words += ["--target", f"{line}=serial:{path}" if line else f"serial:{path}"]
        words += [word for suite in peer.subject.suites for word in ("--suite", suite)]
        words += ["-k", select] if (select := peer.subject.selects("")) else []
        done = subprocess.run(
            [sys.executable, "-m", "hilbench", *words], cwd=ROOT, check=False, capture_output=True, text=True
        )
        if not report.is_file():
            return {"error": 1}, {"check": done.stderr.strip()}
        return verdicts_of(json.loads(report.read_text(encoding="utf-8"))["cases"])


def runs_of(file: Path, commit: str) -> list[Run]:
    """Return what has been run of a commit."""
    return [one for one in read(file, Run) if one.commit == commit]


def missing(found: Sequence[Run], names: Sequence[str], wheres: Sequence[str]) -> list[tuple[RightPeer, str, int]]:
    """Return the runs that are still to be made: who, where, and the seed."""
    done = {(one.peer, one.where, one.seed) for one in found}
    return [
        (peer, where, seed)
        for where, times in TIMES.items()
        for seed in range(times)
        for peer in RIGHT.values()
        if (peer.name, where, seed) not in done
        and (not names or peer.name in names)
        and (not wheres or where in wheres)
    ]


def table(found: Sequence[Run]) -> str:
    """Return the results as a table in Markdown, and what accuses a peer below it."""
    rows = ["| peer | where | runs | passed | failed | inconclusive |", "|---|---|---|---|---|---|"]
    for name, where in sorted({(one.peer, one.where) for one in found}):
        runs = [one for one in found if (one.peer, one.where) == (name, where)]
        sums = sum((Counter(one.verdicts) for one in runs), Counter())
        figures = (len(runs), sums["pass"], sums["fail"] + sums["error"], sums["inconclusive"])
        rows.append(f"| {name} | {where} | " + " | ".join(map(str, figures)) + " |")
    for one in found:
        rows += [f"\n{one.peer}, {one.where}, seed {one.seed}: {case}: {cause}" for case, cause in one.accused.items()]
    return "\n".join(rows) + "\n"


def is_good(found: Sequence[Run]) -> bool:
    """Say whether no peer was accused, and few cases were inconclusive."""
    sums = sum((Counter(one.verdicts) for one in found), Counter())
    judged = sums["pass"] + sums["inconclusive"]
    return not sums["fail"] + sums["error"] and sums["inconclusive"] <= MOST_INCONCLUSIVE * judged


def main() -> int:
    """Make the runs that are missing, and print what there is of the last commit."""
    parser = argparse.ArgumentParser(prog="python -m measure.right_peers", description=__doc__)
    parser.add_argument("--report", action="store_true", help="print what has been run of the last commit, run nothing")
    parser.add_argument("--out", type=Path, default=OUT, help="where results are kept (default: out/right-peers)")
    parser.add_argument("--where", action="append", default=[], choices=TIMES, help="there alone (repeatable)")
    parser.add_argument("peers", nargs="*", metavar="PEER", help=f"all if left out: {', '.join(RIGHT)}")
    options = parser.parse_args()
    if unknown := set(options.peers) - set(RIGHT):
        parser.error(f"no peer: {', '.join(sorted(unknown))}; there are: {', '.join(RIGHT)}")
    options.out.mkdir(parents=True, exist_ok=True)
    file, commit = options.out / "results.jsonl", git("rev-parse", "--short=10", "HEAD")
    found = runs_of(file, commit)
    todo = [] if options.report else missing(found, options.peers, options.where)
    for number, (peer, where, seed) in enumerate(todo, 1):
        loops = busy_loops(BUSY_LOOPS) if where == "busy" else contextlib.nullcontext()
        check = checked_in_memory if where == "memory" else checked_at_pty
        with loops:
            verdicts, accused = check(peer, seed)
        one = Run(commit=commit, peer=peer.name, where=where, seed=seed, verdicts=verdicts, accused=accused)
        with file.open("a", encoding="utf-8") as results:
            results.write(json.dumps(asdict(one)) + "\n")
        sys.stderr.write(f"{number}/{len(todo)} {peer.name} {where} {seed}: {verdicts} {list(accused) or ''}\n")
    found = runs_of(file, commit)
    sys.stdout.write(table(found))
    return 0 if is_good(found) and not missing(found, [], []) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.stderr.write("interrupted; what was run is kept\n")
        sys.exit(130)
