"""A board on the desk in the place of an emulated one: a user's own suite speaks to one of its USARTs at a port.

Nothing is sent but by the cases. Between two of them the board is listened to until it is quiet, and what it said is
forgotten; it is not reset, unless the bench file says how (``[port] reset``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar

from hilbench.bench import Bench
from hilbench.bench.cases import CaseBase
from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer, Sound, Unsound
from hilbench.bench.locked_providers import AttachedProviderBase
from hilbench.bench.protocol_peer import RAW, ProtocolPeer
from hilbench.bench.shared import Shared
from hilbench.benchfile.bench_file import BenchFile
from hilbench.errors import UsageError
from hilbench.judging.provider import CaseInfo
from hilbench.judging.verdicts import NotApplicable
from hilbench.links import Port
from hilbench.mcu.under_test import SerialLine
from hilbench.nearest import did_you_mean
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.terminal.options import TargetChoice

__all__ = ["AttachedBoard", "AttachedBoardCase", "AttachedBoardProvider", "protocol_at"]


class _Listener(ProtocolPeer):
    """Our end of the line, which also keeps the bytes as they came."""

    def __init__(self, bench: Bench, port: Port, protocol: ProtocolPlugin) -> None:
        super().__init__(bench, port, protocol)
        self._begin_line()

    def _begin_line(self) -> None:
        self.line = SerialLine(self.bench, self.port, self.write, self.require_line)

    def _read(self, data: bytes, at_ns: int) -> Iterator[Sound[Any] | Unsound]:
        self.line.take(data, at_ns)
        return super()._read(data, at_ns)

    def settle(self) -> None:
        """See `ProtocolPeer`; the line begins anew, too."""
        super().settle()
        self._begin_line()


class AttachedBoard:
    """What a suite can do with a board of which only one USART is at hand; see `BoardUnderTest` for the whole of one.

    Args:
        name: of the board in the bench file.
        usart: which of its USARTs is at the port.
        peer: our end of its line.

    Attributes:
        name: as given.
    """

    def __init__(self, name: str, usart: str, peer: _Listener) -> None:
        self.name = name
        self._usart = usart
        self._peer = peer

    @property
    def now_s(self) -> float:
        """Bench time since the run began, in seconds."""
        return self._peer.bench.now_s

    def run(self, seconds: float) -> None:
        """Let `seconds` of bench time pass; UnavailableError if the line goes down."""
        self._peer.run(seconds)

    def run_until(self, condition: Callable[[], bool], within_s: float) -> bool:
        """Let time pass until `condition` holds or `within_s` seconds are over; say whether it holds.

        Raises:
            UnavailableError: it does not, and the line is down.
        """
        if self._peer.bench.run_until(condition, within_s):
            return True
        self._peer.require_line()
        return False

    def usart(self, name: str) -> SerialLine:
        """Return the line of the USART that is at the port.

        Raises:
            NotApplicable: another one is.
        """
        if name.lower() != self._usart:
            raise NotApplicable(f"{name} of {self.name} is not at the port: {self._usart} is")
        return self._peer.line

    def __getattr__(self, name: str) -> Any:
        raise NotApplicable(f"a port shows no '{name}' of a board")


class AttachedBoardCase(CaseBase):
    """A case on a board at a port.

    Attributes:
        peer: our end of the line, with the frames of the protocol that the bench file names for it; else bytes as they
            came.
        board: the board.
        boards: the same by its name.
    """

    def __init__(self, bench: Bench, case: CaseInfo, peer: _Listener, faults: LineFaults | None, at: str) -> None:
        super().__init__(bench, case, faults)
        self.peer = peer
        name, _, usart = at.partition(".")
        self.board = AttachedBoard(name, usart, peer)
        self.boards: Mapping[str, AttachedBoard] = {name: self.board}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        raise NotApplicable(f"a board at a port has no '{name}'")

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        return {"host": self.peer}


class AttachedBoardProvider(AttachedProviderBase[_Listener, AttachedBoardCase]):
    """Hands a board at a port to one case after the other.

    Args:
        shared: bench file, journal, waiting.
        choice: the port, and by its name what is there: a line of the checker, a USART as ``brain.usart2``, or a board.
            Of a board, and where nothing is named, it is the USART that the checker's line leads to, and otherwise the
            console or the first one.

    Raises:
        UsageError: the bench has no such board, or the board no such USART.
    """

    USUAL_BAUD: ClassVar[int] = 115200
    """The rate of a port of which the command line says none, in bit/s (choice)."""

    def __init__(self, shared: Shared, choice: TargetChoice) -> None:
        at = _usart_meant(shared.bench_file, choice)
        self._protocol = shared.bench_file.protocols.get(at, RAW)
        super().__init__(shared, choice.spec, None if self._protocol is RAW else self._protocol.baud)
        self._at = at

    @property
    def capabilities(self) -> frozenset[str]:
        """The protocol that the bench file names for the line; else none that a clause could name."""
        return frozenset({self._protocol.title}) - {RAW.title}

    def describe(self) -> Mapping[str, str]:
        """Name the port, its rate, and what is there."""
        about = super().describe()
        return {
            **about,
            "target": f"{self._at} at {self._serial.url}, {self._serial.baud} baud, not reset between cases",
        }

    def _make_peer(self, port: Port) -> _Listener:
        return _Listener(self._bench, port, self._protocol)

    def _make_case(
        self, case: CaseInfo, peer: _Listener, reopen: Callable[[], Port], faults: LineFaults | None = None
    ) -> AttachedBoardCase:
        del reopen  # no case hangs up
        if case.scene:
            raise NotApplicable(f"a board at a port stands in no scene '{case.scene}'")
        return AttachedBoardCase(self._bench, case, peer, faults, self._at)


def protocol_at(bench_file: BenchFile, choice: TargetChoice) -> ProtocolPlugin:
    """Return what the bench file says is spoken at the USART that a port stands for; raw bytes where it says nothing.

    Raises:
        UsageError: the bench has no such board, or the board no such USART.
    """
    return bench_file.protocols.get(_usart_meant(bench_file, choice), RAW)


def _usart_meant(bench_file: BenchFile, choice: TargetChoice) -> str:
    lines = {name: end for name, end in bench_file.checker_lines.items() if end.partition(".")[0] in bench_file.boards}
    named = lines.get(choice.name) or choice.name or next(iter([*lines.values(), *bench_file.boards]))
    board, _, usart = named.partition(".")
    if board not in bench_file.boards:
        hint = did_you_mean(board, [*bench_file.boards, *filter(None, lines)], "boards and lines")
        raise UsageError(f"no board '{board}' on this bench", where=choice.where, hint=hint)
    usarts = [name.lower() for name in bench_file.boards[board].board.usarts]
    led_to = (end.partition(".")[2] for end in lines.values() if end.partition(".")[0] == board)
    usart = usart.lower() or next(led_to, usarts[0])
    if usart not in usarts:
        hint = did_you_mean(usart, usarts, "USARTs")
        raise UsageError(f"no USART '{usart}' of {board} can be reached", where=choice.where, hint=hint)
    return f"{board}.{usart}"
