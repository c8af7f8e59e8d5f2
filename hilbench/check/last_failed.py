"""Which cases of a bench did not pass when they were run last, for ``--last-failed``.

It is a cache in the sense of the XDG Base Directory Specification: what is lost costs a run of all cases. Each bench
and target has a file of its own; a case leaves it when it has passed.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from pathlib import Path

from hilbench.check.results import Report
from hilbench.errors import UnavailableError
from hilbench.files import write_atomically
from hilbench.judging.verdicts import Verdict
from hilbench.terminal.options import DEFAULT_BENCH, CheckOptions

__all__ = ["known", "remember"]

_FAILED = {Verdict.FAIL, Verdict.ERROR, Verdict.INCONCLUSIVE}


def known(options: CheckOptions) -> frozenset[str]:
    """Return the ids of the cases that did not pass; none if nothing is known of that bench and target."""
    file = _file(options)
    if file is None:
        return frozenset()
    try:
        return frozenset(map(str, json.loads(file.read_text(encoding="utf-8"))["cases"]))
    except (OSError, ValueError, KeyError, TypeError):
        return frozenset()


def remember(report: Report, options: CheckOptions) -> None:
    """Take over what a run has shown; what cannot be written is not remembered."""
    failed = {case.id for case in report.cases if case.verdict in _FAILED}
    passed = {case.id for case in report.cases if case.verdict is Verdict.PASS}
    file, before = _file(options), known(options)
    after = before - passed | failed
    if file is None or after == before:
        return
    text = json.dumps({"bench": _bench(options), "targets": _targets(options), "cases": sorted(after)}, indent=1)
    with contextlib.suppress(OSError, UnavailableError):
        file.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(file, f"{text}\n")


def _file(options: CheckOptions) -> Path | None:
    # where there is no home, Path.expanduser would raise
    cache = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))  # noqa: PTH111
    if not cache.is_absolute():
        return None
    about = json.dumps([_bench(options), _targets(options)])
    return cache / "hilbench" / "last-failed" / f"{hashlib.sha256(about.encode()).hexdigest()[:32]}.json"


def _bench(options: CheckOptions) -> str:
    """Return what tells one bench from another: the whole path of a file, or the name of one that is built in."""
    file = Path("hilbench.toml" if options.bench is None else options.bench)
    return str(file.resolve()) if file.is_file() else options.bench or DEFAULT_BENCH


def _targets(options: CheckOptions) -> list[str]:
    return [target.where for target in options.targets] + [change.where for change in options.changes]
