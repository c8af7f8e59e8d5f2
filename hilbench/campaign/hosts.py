"""Runs the points of a campaign on many hosts, by Dask: a scheduler that somebody has started, and its workers.

A worker that dies costs time alone: its points are run elsewhere. The results are kept here, and nowhere else.
"""

from __future__ import annotations

import itertools
import logging
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import CancelledError
from typing import TYPE_CHECKING

from hilbench.campaign.digests import own_digest
from hilbench.campaign.point import Outcome, Point
from hilbench.campaign.shipping import Parcel, pack, run_shipped
from hilbench.errors import UnavailableError, UsageError
from hilbench.exit_codes import ExitCode

if TYPE_CHECKING:
    from distributed import Client, Future

__all__ = ["run_there"]

_ADDRESS = re.compile(r"([a-z]+://)?[^\s/]+:\d+")
_AHEAD = 4
"""Points that each thread of a worker has before it (choice): none waits for this host."""
_LEAST_AHEAD = 32
_DEATHS = 5
"""So often a point is given out again after Dask has given it up, which it does when four workers have died of it."""
_WAIT_S = 10

_DIED = Outcome(verdict="error", exit_code=ExitCode.DEFECT, cause="every worker that ran it died: out of memory?")


def run_there(points: Mapping[str, Point], scheduler: str) -> Iterator[tuple[str, Outcome]]:
    """Yield what comes of points, as it comes.

    Args:
        points: by their keys.
        scheduler: its address, such as ``tcp://10.0.0.5:8786``.

    Raises:
        UsageError: the address is none.
        UnavailableError: Dask is not installed, the scheduler is not there, or a worker has another hilbench.
    """
    try:
        from distributed import Client
    except ImportError:
        hint = "pip install 'hilbench[campaign]'"
        raise UnavailableError("--scheduler needs Dask, which is not installed", hint=hint) from None
    if not _ADDRESS.fullmatch(scheduler):
        raise UsageError("is no address", where=f"--scheduler {scheduler}", hint="such as tcp://10.0.0.5:8786")
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what it tells of is said here in one line
    try:
        client = Client(scheduler, timeout=_WAIT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UnavailableError(f"no scheduler answers: {error}", where=f"--scheduler {scheduler}") from None
    with client:
        _check_workers(client, scheduler)
        try:
            yield from _Giving(client, points, pack(points.values())).outcomes()
        except (CancelledError, OSError) as error:
            hint = "what was run is kept: the same command goes on"
            raise UnavailableError(
                f"the scheduler has gone: {error}", where=f"--scheduler {scheduler}", hint=hint
            ) from None


def _check_workers(client: Client, scheduler: str) -> None:
    # A worker that leaves meanwhile answers with an error; whoever comes later is asked with each point.
    answers = client.run(own_digest, on_error="return")
    digests = {worker: answer for worker, answer in answers.items() if isinstance(answer, str)}
    if not digests:
        hint = "start one: dask worker ADDRESS --nthreads 1"
        raise UnavailableError("the scheduler has no worker", where=f"--scheduler {scheduler}", hint=hint)
    for worker, digest in digests.items():
        if digest != own_digest():
            raise UnavailableError(
                "has another hilbench", where=f"worker {worker}", hint="install the same wheel there"
            )


class _Giving:
    """Gives points out, a few at a time, and takes what comes back."""

    def __init__(self, client: Client, points: Mapping[str, Point], parcel: Parcel) -> None:
        self._client = client
        self._points = points
        self._parcel = parcel
        self._deaths: Counter[str] = Counter()
        self._running: dict[Future, str] = {}

    def outcomes(self) -> Iterator[tuple[str, Outcome]]:
        from distributed import as_completed
        from distributed.scheduler import KilledWorker

        waiting = iter(self._points)
        ahead = max(_LEAST_AHEAD, _AHEAD * sum(self._client.nthreads().values()))
        ready = as_completed(loop=self._client.loop)
        for key in itertools.islice(waiting, ahead):
            ready.add(self._give(key))
        for future in ready:
            key = self._running.pop(future)
            try:
                outcome = future.result()
            except KilledWorker:
                self._deaths[key] += 1
                outcome = _DIED if self._deaths[key] > _DEATHS else None
            if outcome is None:
                ready.add(self._give(key, self._parcel.files))
                continue
            yield key, outcome
            following = next(waiting, None)
            if following is not None:
                ready.add(self._give(following))

    def _give(self, key: str, files: Mapping[str, bytes] | None = None) -> Future:
        arguments = self._points[key], self._parcel.digest, files, own_digest()
        future = self._client.submit(run_shipped, *arguments, pure=False)
        self._running[future] = key
        return future
