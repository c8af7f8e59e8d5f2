"""What the command line hands to the bench: plain values, understood but not yet looked up."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hilbench.strict.changes import Change

DEFAULT_BENCH = "pioneer"
"""The bench that is meant where none is named and no file is there."""

ITS_DOMAINS = -1
"""As the number of a DDS domain: that which a target itself names for each of its topics."""

DEFAULT_DEMO = "rover"
"""The system whose demo is played where none is named."""

THROUGH = ("pty", "tcp", "rfc2217", "proxy")
"""What ``check --through`` takes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetChoice:
    """One ``--target [NAME=]T``.

    Attributes:
        spec: the TARGET, such as the name of a model or ``serial:/dev/ttyUSB0@9600``.
        name: the target of the bench file that it replaces, or the line of the checker that it is at the far end of;
            empty for the only one.
    """

    spec: str
    name: str = ""

    @property
    def where(self) -> str:
        """The option as it was written, for messages."""
        return f"--target {self.name}={self.spec}" if self.name else f"--target {self.spec}"


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckOptions:
    """What ``hilbench check`` was asked to do.

    Attributes:
        bench: name of a built-in bench or path of a bench file; None for ``./hilbench.toml`` if it exists, else
            `DEFAULT_BENCH`.
        targets: the targets to use instead of those of the bench file.
        suites: names of shipped suites, or paths of suite files or folders; empty for all shipped ones.
        select: the expression of ``-k``; empty for all cases.
        seed: seed of the run.
        strict: whether a *should* counts like a *must*.
        timeout_scale: how much longer than usual to wait, at least 1.
        junit: where to write JUnit XML.
        json: where to write the JSON report; ``-`` is standard output.
        journal: where to write the journal.
        journal_max: how large it and the part before it may get together, in bytes; None for no limit.
        through: one of `THROUGH`: the bytes pass an endpoint of this kind; empty for lines in memory.
        screens: the folder for pictures of the dashboard at the moment at which a case fails.
        list_only: list the cases and run nothing.
        jobs: how many processes run cases, at least 1.
        plugins: the files of ``--plugin``.
        changes: changes to the bench file, as of ``--set``.
        max_failures: how many failed cases end the run; 0 for no limit.
        last_failed: run only the cases that did not pass in the last run.
        rerun_inconclusive: how often to repeat an inconclusive case.
        quiet: print only what did not pass, and the last line.
        ci: the CI system: ``github``, ``gitlab``, ``none``, or ``auto`` to find out from the environment.
        code_quality: where to write a Code Quality report, as GitLab reads it.
        html: where to write the page of the run.
        operator: ask the operator at the terminal for manual actions on the target.
        operator_hook: the words of a command that is asked first, or instead; empty for none.
    """

    bench: str | None = None
    targets: tuple[TargetChoice, ...] = ()
    suites: tuple[str, ...] = ()
    select: str = ""
    seed: int = 0
    strict: bool = False
    timeout_scale: float = 1.0
    junit: Path | None = None
    json: str | None = None
    journal: Path | None = None
    journal_max: int | None = None
    through: str = ""
    screens: Path | None = None
    list_only: bool = False
    jobs: int = 1
    plugins: tuple[Path, ...] = ()
    changes: tuple[Change, ...] = ()
    max_failures: int = 0
    last_failed: bool = False
    rerun_inconclusive: int = 0
    quiet: bool = False
    ci: str = "none"
    code_quality: Path | None = None
    html: Path | None = None
    operator: bool = False
    operator_hook: tuple[str, ...] = ()

    def outputs(self) -> tuple[tuple[str, Path | None], ...]:
        """Return the files to write, by the options that name them."""
        json = None if self.json in {None, "-"} else Path(str(self.json))
        return (
            ("--junit", self.junit),
            ("--json", json),
            ("--journal", self.journal),
            ("--code-quality", self.code_quality),
            ("--html", self.html),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PtyDoor:
    """One ``--pty [LINK=]PATH``: a pseudo-terminal with a stable name.

    Attributes:
        path: the symbolic link to make.
        link: what it opens: a USART of an emulated board, as ``usart2`` or ``brain.usart2``; empty for the only link
            of the bench, or the next USART.
    """

    path: Path
    link: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class TcpDoor:
    """One ``--tcp [LINK=][HOST:]PORT``: a listening socket.

    Attributes:
        port: TCP port, 0 to 65535; 0 lets the system choose.
        host: address to listen at.
        link: what it opens: a USART of an emulated board, as ``usart2`` or ``brain.usart2``; empty for the only link
            of the bench, or the next USART.
    """

    port: int
    host: str = "127.0.0.1"
    link: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Rfc2217Door(TcpDoor):
    """One ``--rfc2217 [LINK=][HOST:]PORT``: a listening socket for clients that set the rate of the line."""


DoorWish = PtyDoor | TcpDoor | Rfc2217Door


class Clients(enum.StrEnum):
    """Who is served where several clients come to one line: ``--clients``."""

    ALL = "all"
    """Each: the line has the bytes of whoever is there, and each gets what comes out."""
    NEWEST = "newest"
    """Who came last: those before are disconnected."""
    FIRST = "first"
    """Who came first, until he leaves: others are turned away."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ServeOptions:
    """What ``hilbench serve`` was asked to do.

    Attributes:
        what: a TARGET, the name of a built-in bench, or the path of a bench file.
        ptys: pseudo-terminals to offer.
        tcps: sockets to listen at.
        rfc2217s: as above, for clients of RFC 2217.
        scene: scene to use instead of that of the bench file; None keeps it.
        seed: seed of the run.
        baud: speed of the line in bit/s instead of that of the bench file; None keeps it.
        any_baud: take clients at any speed, without the garbage a wrong speed makes on a real line.
        clients: who is served where several come.
        ignore_hangup: whether the target is not told that a client has left, as on a serial line.
        journal: where to write the journal.
        journal_max: how large it and the part before it may get together, in bytes; None for no limit.
        dds: the DDS domain that the target's topics are joined to, or `ITS_DOMAINS`; None for none.
    """

    what: str
    ptys: tuple[PtyDoor, ...] = ()
    tcps: tuple[TcpDoor, ...] = ()
    rfc2217s: tuple[Rfc2217Door, ...] = ()
    scene: str | None = None
    seed: int = 0
    baud: int | None = None
    any_baud: bool = False
    clients: Clients = Clients.ALL
    ignore_hangup: bool = False
    journal: Path | None = None
    journal_max: int | None = None
    dds: int | None = None

    @property
    def doors(self) -> tuple[DoorWish, ...]:
        """All doors that were wished for."""
        return (*self.ptys, *self.tcps, *self.rfc2217s)

    def outputs(self) -> tuple[tuple[str, Path | None], ...]:
        """Return the files and links to make, by the options that name them."""
        return (*(("--pty", pty.path) for pty in self.ptys), ("--journal", self.journal))
