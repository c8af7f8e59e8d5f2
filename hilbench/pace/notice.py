"""How a bench in real time keeps up, published to whoever on this host has a line to it.

Who serves keeps a file in the runtime folder as long as it runs, ``pace/PID-XXXXXX``; who checks finds it by the port
that it opened (`hilbench.pace.far_pace`), and maps it. All times in it are the host's
monotonic clock, which all processes of a host share, in ns. It is an array of 64-bit integers in the order of the host:

====================  =================================================================================================
`_FORMAT`             of this file
`_BORN`               when the bench began to run; before that nobody was there to answer
`_DUE`                when the next thing is to happen: the bench has been there, and is no further until it is done
`_STEP`               how late it may take what comes from outside, for it runs so far ahead
`_LOST`, `_LOSSES`    how long its time stood still in all, and how often
`_LATE`               for each bucket of `hilbench.clock.LatenessMeter`, when it was last so late: so the greatest
                      lateness since any moment can be told, however long ago that was
`_LOSS`               a ring of the last losses: when, and how much was lost before
`_WORDS`, `_WORD`     how many entries have sent anything outside, and a ring of the last: when each was due, began
                      and was done, and by which doors it sent, a bit for each
====================  =================================================================================================

Behind it stands, as JSON, which doors lead to it and which ports it has opened itself. Its owner has the file locked
(flock(2)): a file that can be locked is that of a process which is gone, and is removed by whoever finds it. Until all
is written its name begins with a dot; who was killed meanwhile is cleared away by the next that serves.
"""

from __future__ import annotations

import contextlib
import fcntl
import mmap
import os
import stat
import tempfile
import weakref
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType

import msgspec

from hilbench.clock import NS_PER_MS, LatenessMeter
from hilbench.errors import UnavailableError
from hilbench.files.runtime_folder import check_private, made_private, runtime_folder
from hilbench.pace.lateness import Lateness

__all__ = ["PaceNotice", "PaceReader", "notices"]

_FORMAT, _BORN, _DUE, _STEP, _LOST, _LOSSES, _LATE = range(7)
_LOSS = _LATE + LatenessMeter.BUCKETS
_LOSSES_KEPT = 512
_WORDS = _LOSS + 2 * _LOSSES_KEPT
_WORD = _WORDS + 1
_WORDS_KEPT = 512
_OF_A_WORD = 4
_NUMBERS = _WORD + _OF_A_WORD * _WORDS_KEPT
_BYTES = _NUMBERS * 8
_THIS_FORMAT = 2
_NEVER_NS = 1 << 62
_BEFORE_NS = 10 * NS_PER_MS
"""What happened so shortly before a stretch of time may still be on its way when that begins (choice)."""
_SILENT_NS = 50 * NS_PER_MS
"""Who is so late may have been killed; before that nobody looks (choice)."""
_MADE_WITHIN_S = 60
"""So long a file may be there that is not locked yet (choice)."""
_MOST_BYTES = _BYTES + 1_000_000
"""No notice is so large: it names a few ports (choice)."""


class _About(msgspec.Struct, frozen=True, kw_only=True):
    doors: tuple[str, ...]
    behind: tuple[str, ...]


class PaceNotice:
    """The file of a bench that runs: a `hilbench.clock.PaceListener`.

    Args:
        born_ns: the host's monotonic time now, in ns.
        doors: the places (`hilbench.pace.far_pace.place_of`) of the doors that lead to the bench.
        behind: paths and URLs of the ports that the bench has opened itself, to hand on what passes.
        step_ns: how far it runs ahead of the host's clock, and so takes what comes from outside late.

    Raises:
        OSError: it cannot be written.
        UnavailableError: the runtime folder is not the user's own.
    """

    def __init__(self, born_ns: int, doors: Sequence[str], *, behind: Sequence[str] = (), step_ns: int = 0) -> None:
        made_private(runtime_folder())
        folder = made_private(_folder())
        about = msgspec.json.encode(_About(doors=tuple(doors), behind=tuple(behind)))
        descriptor, new = tempfile.mkstemp(prefix=".", dir=folder)
        self.path = folder / f"{os.getpid()}-{Path(new).name[1:]}"
        self._file = os.fdopen(descriptor, "r+b")
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX)
            self._file.write(bytes(_BYTES) + about)
            self._file.flush()
            self._map = mmap.mmap(descriptor, _BYTES)
            self._numbers = memoryview(self._map).cast("q")
            self._late = LatenessMeter(self._numbers[_LATE:_LOSS])
            self._numbers[_FORMAT] = _THIS_FORMAT
            self._numbers[_BORN] = self._numbers[_DUE] = born_ns
            self._numbers[_STEP] = step_ns
            Path(new).rename(self.path)  # only now it can be found
            _clear_unfinished(folder, os.fstat(descriptor).st_mtime - _MADE_WITHIN_S)
        except OSError:
            self._file.close()
            Path(new).unlink(missing_ok=True)
            raise

    def due(self, host_ns: int) -> None:
        """Tell when the next entry is due."""
        self._numbers[_DUE] = host_ns

    def ran(self, due_ns: int, began_ns: int, done_ns: int, *, spoke: int) -> None:
        """Tell how late an entry was done: what it did, it did no later."""
        self._late.record(max(0, done_ns - due_ns), done_ns)
        if spoke:
            numbers = self._numbers
            at = _WORD + _OF_A_WORD * (numbers[_WORDS] % _WORDS_KEPT)
            numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3] = due_ns, began_ns, done_ns, spoke
            numbers[_WORDS] += 1

    def slipped(self, slip_ns: int, host_ns: int) -> None:
        """Tell that bench time stood still."""
        numbers = self._numbers
        lost_ns, losses = numbers[_LOST], numbers[_LOSSES]
        at = _LOSS + 2 * (losses % _LOSSES_KEPT)
        numbers[at], numbers[at + 1] = host_ns, lost_ns
        numbers[_LOSSES] = losses + 1
        numbers[_LOST] = lost_ns + slip_ns
        numbers[_DUE] = host_ns

    def close(self) -> None:
        """Take it back: who still looks at it finds nothing late any more."""
        self.path.unlink(missing_ok=True)
        self._numbers[_DUE] = _NEVER_NS
        del self._late
        self._numbers.release()
        self._map.close()
        self._file.close()

    def __enter__(self) -> PaceNotice:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class PaceReader:
    """What somebody else's file says.

    Args:
        path: the file.

    Raises:
        OSError: it is gone, its owner is, or it is none.

    Attributes:
        name: of the file.
        doors: the places of the doors that lead to the bench.
        behind: paths and URLs of the ports that it has opened itself.
    """

    def __init__(self, path: Path) -> None:
        self._descriptor = _opened(path)
        weakref.finalize(self, os.close, self._descriptor)
        size = os.fstat(self._descriptor).st_size
        if _is_left_behind(self._descriptor):
            path.unlink(missing_ok=True)
            raise OSError("its owner is gone")
        if not _BYTES < size <= _MOST_BYTES:
            raise OSError("is no notice")
        text = os.pread(self._descriptor, size, _BYTES)
        try:
            about = msgspec.json.decode(text, type=_About)
            self._map = mmap.mmap(self._descriptor, _BYTES, access=mmap.ACCESS_READ)
        except (msgspec.MsgspecError, ValueError) as error:
            raise OSError("is no notice") from error
        self._numbers = memoryview(self._map).cast("q")
        if self._numbers[_FORMAT] != _THIS_FORMAT:
            raise OSError("is a notice of another release")
        self.name, self.doors, self.behind = path.name, about.doors, about.behind

    def has_ended(self, now_ns: int) -> bool:
        """Say whether the bench runs no more: it took its notice back, or was killed and is found late now."""
        due_ns = self._numbers[_DUE]
        return due_ns == _NEVER_NS or (now_ns - due_ns > _SILENT_NS and _is_left_behind(self._descriptor))

    def lateness(self, since_ns: int, now_ns: int) -> Lateness:
        """Return how late the bench was between two moments, of which the second is now; never understated.

        What it is late by right now counts, and the time before it began.
        """
        missed_ns = max(0, self._numbers[_BORN] - since_ns)
        since_ns -= _BEFORE_NS
        meter = LatenessMeter(self._numbers[_LATE:_LOSS])
        meter.max_ns = _NEVER_NS
        late_ns = max(meter.max_since_ns(since_ns), now_ns - self._numbers[_DUE])
        return Lateness(late_ns=late_ns + self._numbers[_STEP], lost_ns=missed_ns + self._lost_since_ns(since_ns))

    def due_between(self, place: str, after_ns: int, by_ns: int) -> tuple[int, int] | None:
        """Return when was due, at the earliest and at the latest, what the bench sent at some moment between two.

        It may have run ahead of what was due, by its step. None if nothing is remembered that it can have been.

        Args:
            place: where it sent it: of one of its doors.
            after_ns: the first moment.
            by_ns: the second.
        """
        numbers, door = self._numbers, 1 << self.doors.index(place)
        due_ns, words = numbers[_DUE], numbers[_WORDS]  # in this order: what is being done is one of these or the other
        found = [due_ns] if due_ns <= by_ns else []
        for word in range(words - 1, max(0, words - _WORDS_KEPT + 1) - 1, -1):
            at = _WORD + _OF_A_WORD * (word % _WORDS_KEPT)
            if numbers[at + 2] < after_ns:
                break
            if numbers[at + 1] <= by_ns and numbers[at + 3] & door:
                found.append(numbers[at])
        else:
            if words >= _WORDS_KEPT:
                return None
        return (min(found) - numbers[_STEP], max(found) + numbers[_STEP]) if found else None

    def lived_ns(self, now_ns: int) -> int:
        """Return how far the time of the bench has come at a moment, which is now, from a beginning of its own."""
        return min(now_ns, self._numbers[_DUE]) - self._numbers[_LOST]

    def _lost_since_ns(self, since_ns: int) -> int:
        numbers = self._numbers
        losses, lost_ns = numbers[_LOSSES], numbers[_LOST]
        before_ns = lost_ns
        for loss in range(losses - 1, max(0, losses - _LOSSES_KEPT) - 1, -1):
            at = _LOSS + 2 * (loss % _LOSSES_KEPT)
            if numbers[at] < since_ns:
                return lost_ns - before_ns
            before_ns = numbers[at + 1]
        return lost_ns  # no loss before that is remembered


def notices() -> Iterator[PaceReader]:
    """Return the files of all benches of this user that tell how they keep up on this host."""
    folder = _folder()
    with contextlib.suppress(OSError, UnavailableError):
        check_private(folder)
        for path in sorted(folder.iterdir()):
            if not path.name.startswith("."):
                with contextlib.suppress(OSError):
                    yield PaceReader(path)


def _folder() -> Path:
    return runtime_folder() / "pace"


def _opened(path: Path) -> int:
    """Open a file, which may be none: then nothing is waited for, and nothing is followed."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError("is no file")
    return descriptor


def _clear_unfinished(folder: Path, before_s: float) -> None:
    """Remove what was last written before a time, in seconds of the file system, by who was killed before it was done.

    That is not done by whoever looks: how old a file is can be told by a newer one alone, for the host's monotonic time
    is not that of files.
    """
    for path in folder.glob(".*"):
        with contextlib.suppress(OSError):
            descriptor = _opened(path)
            try:
                if os.fstat(descriptor).st_mtime < before_s and _is_left_behind(descriptor):
                    path.unlink()
            finally:
                os.close(descriptor)


def _is_left_behind(descriptor: int) -> bool:
    """Say whether nobody has the file locked."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    fcntl.flock(descriptor, fcntl.LOCK_UN)
    return True
