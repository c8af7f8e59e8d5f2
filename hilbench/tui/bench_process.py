"""The bench of a dashboard: a process in a session of its own, its socket, its last words.

The dashboard is never waited for by the bench, and does not wait for it either: everything here returns at once.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Any

from hilbench.driving.local_socket import connect_to
from hilbench.exit_codes import ExitCode
from hilbench.live.folders import Session, new_session

__all__ = ["BenchProcess", "Phase"]

_READ_BYTES = 65536
_ENDING_S = 2.0
"""How long a process may take to end that has given up its socket (choice)."""
_LAST_WORDS = 400
_PATIENCE_S = 5.0


class Phase(Enum):
    """How far a bench is."""

    STARTING = "starting"
    LIVE = "live"
    ENDED = "ended"


class BenchProcess:
    """See the module.

    Args:
        session: its folder.
        process: the process, if it is ours; None of one that was found running.

    Attributes:
        phase: how far it is.
        cause: why it ended; empty while it has not.
        detached: whether it was left to itself.
    """

    def __init__(self, session: Session, process: subprocess.Popen[bytes] | None = None) -> None:
        self.session = session
        self.phase = Phase.STARTING
        self.cause = ""
        self.detached = False
        self._process = process
        self._socket: socket.socket | None = None
        self._data = b""
        self._number = 0
        self._began = False
        self._asked: dict[int, str] = {}
        self._hold = session.hold()
        if process is not None and process.stdout is not None:
            os.set_blocking(process.stdout.fileno(), False)

    @classmethod
    def start(cls, words: Sequence[str], *, name: str) -> BenchProcess:
        """Start a bench.

        Args:
            words: which, and how, as ``hilbench live`` takes them; the default bench if none is named.
            name: for its folder.

        Raises:
            UnavailableError: there is no place for its folder.
        """
        session = new_session(name)
        with session.talk.open("wb") as talk:
            process = subprocess.Popen(
                [sys.executable, "-m", "hilbench", "live", *words, "--folder", str(session.folder)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=talk,
                start_new_session=True,
            )
        return cls(session, process)

    @property
    def ended_well(self) -> bool:
        """Whether it ended in good order: nothing of it is kept then but a journal that was asked for."""
        return self._process is not None and self._process.poll() == ExitCode.OK

    @property
    def never_began(self) -> ExitCode:
        """The error with which a bench of ours ended by itself before it was there; OK of any other."""
        if self._process is None or self._began or self.phase is not Phase.ENDED:
            return ExitCode.OK
        code = self._process.poll()
        return next((one for one in ExitCode if one == code), ExitCode.DEFECT)

    @property
    def about(self) -> Mapping[str, Any]:
        """What the bench says of itself; nothing before it is live."""
        return self.session.describe()

    @property
    def journal(self) -> Path:
        """Where its journal is."""
        return Path(str(self.about.get("journal", self.session.journal)))

    @property
    def actions(self) -> Sequence[str]:
        """What it can do."""
        return tuple(map(str, self.about.get("actions", ())))

    # --- what goes on

    def poll(self) -> list[str]:
        """Look at process and socket; return why requests were refused."""
        if self.phase is Phase.STARTING:
            self._poll_start()
        refused = self._read_answers() if self.phase is Phase.LIVE else []
        if self.phase is not Phase.ENDED and self._process is not None and self._process.poll() is not None:
            self._end(self._cause_of(self._process.returncode))
        return refused

    def _poll_start(self) -> None:
        if self._process is not None and self._process.stdout is not None:
            try:
                if not self._process.stdout.read(_READ_BYTES):
                    return
            except OSError:
                return
        self._connect()

    def _connect(self) -> None:
        try:
            client = connect_to(self.session.socket)
        except OSError as error:
            code = self._ended_code()
            self._end(f"the bench does not answer: {error.strerror}" if code is None else self._cause_of(code))
            return
        client.setblocking(False)
        self._socket = client
        self.phase = Phase.LIVE
        self._began = True
        self.send("hello")

    def _ended_code(self) -> int | None:
        """Return with what a process of ours has ended that has just said it is live; None if it goes on."""
        if self._process is None:
            return None
        try:
            return self._process.wait(_ENDING_S)
        except subprocess.TimeoutExpired:
            return None

    def _read_answers(self) -> list[str]:
        if self._socket is None:
            return []  # it has hung up, and is about to end
        try:
            data = self._socket.recv(_READ_BYTES)
        except BlockingIOError:
            return []
        except OSError:
            data = b""
        if not data:
            self._socket.close()
            self._socket = None
            if self._process is None:
                self._end(self._cause_of(None))
            return []  # how one of ours has ended is known once its process has
        *lines, self._data = (self._data + data).split(b"\n")
        return [refusal for line in lines if (refusal := self._refusal(line))]

    def _refusal(self, line: bytes) -> str:
        try:
            answer = json.loads(line)
        except ValueError:
            return ""
        asked = self._asked.pop(answer.get("id"), "")
        return "" if answer.get("ok") else f"{asked}: {answer.get('error', 'refused')}"

    def _end(self, cause: str) -> None:
        self.phase = Phase.ENDED
        self.cause = self.cause or cause

    def _cause_of(self, code: int | None) -> str:
        words = self._last_words()
        if code is None:
            how = "the bench hung up"
        elif code < 0:
            how = f"the bench was killed by {signal.Signals(-code).name}"
        elif code == ExitCode.OK:
            return "the bench has ended"
        else:
            how = f"the bench ended with exit code {code}"
        return f"{how}: {words}" if words else how

    def _last_words(self) -> str:
        try:
            said = self.session.talk.read_text(errors="replace").strip()
        except OSError:
            return ""
        return said.splitlines()[-1].removeprefix("hilbench: ")[-_LAST_WORDS:] if said else ""

    # --- what it is told

    def send(self, do: str, **more: object) -> None:
        """Ask for something; an answer that refuses it comes with `poll`. Nothing happens unless the bench is live."""
        if self._socket is None:
            return
        self._number += 1
        self._asked[self._number] = do
        with contextlib.suppress(OSError):
            self._socket.send(json.dumps({"id": self._number, "do": do, **more}).encode() + b"\n")

    def leave(self) -> None:
        """Let the bench run on by itself; it can be found again."""
        self.send("farewell")
        self.detached = True
        self._hang_up()

    def stop(self) -> None:
        """End the bench in good order, and forget its folder where all went well."""
        found = None if self._process is not None or self._socket is None else _opened(self.about.get("pid"))
        self.send("quit")
        self._hang_up()
        if found is not None:
            self._await_found(found)
        if self._process is None:
            return
        if self.phase is Phase.STARTING:
            self._process.terminate()
        try:
            code = self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            code = self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        if code == ExitCode.OK:
            self.session.remove()

    def _await_found(self, process: int) -> None:
        """Forget the folder of a bench that was found running, once it has ended in good order."""
        try:
            ended, _, _ = select.select((process,), (), (), _PATIENCE_S)
        finally:
            os.close(process)
        if ended and self.session.ended_well(self.journal):
            self.session.remove()

    def _hang_up(self) -> None:
        self._hold.release()
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _opened(pid: object) -> int | None:
    """Return a descriptor that is readable once a process has ended; None if there is none to be had."""
    if not isinstance(pid, int) or not hasattr(os, "pidfd_open"):
        return None
    try:
        return os.pidfd_open(pid)
    except OSError:
        return None
