"""The class that pyserial makes for ``hilbench://`` (the module's name is pyserial's convention)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from serial import PortNotOpenError, SerialBase, SerialException, to_bytes

from hilbench.clock import NS_PER_MS
from hilbench.errors import HilbenchError
from hilbench.links.bench_url import parse_bench_url
from hilbench.mcu.command_line import open_target
from hilbench.serving.near_ends import NearEnd
from hilbench.urlhandler.runner import FastRunner, RealTimeRunner, Runner

__all__ = ["Serial"]

_BREAK_NS = NS_PER_MS
"""How long a break that is switched on is held at a time (choice)."""


class Serial(SerialBase):  # type: ignore[misc]  # pyserial has no types
    """A serial port at whose far end is a bench in this process.

    `SerialException` is raised for whatever is wrong, with the words that ``hilbench`` has for it. CTS, DSR and carrier
    are always asserted. In fast mode a timeout is bench time, see `hilbench.urlhandler.runner`.
    """

    BAUDRATES = (*SerialBase.BAUDRATES, 250_000, 1_500_000, 2_250_000, 4_500_000)

    is_open: bool

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self._runner: Runner | None = None
        super().__init__(*args, **kwargs)

    def open(self) -> None:
        """Build the bench and let it run.

        Raises:
            SerialException: it cannot be built, or the port is open.
        """
        if self._port is None:
            raise SerialException("Port must be configured before it can be used.")
        if self.is_open:
            raise SerialException("Port is already open.")
        try:
            url = parse_bench_url(self._port)
            make: Callable[..., Runner] = FastRunner if url.fast else RealTimeRunner
            self._runner = make(open_target(url.what), line=url.line, baud=self._baudrate, seed=url.seed)
        except HilbenchError as error:
            raise SerialException(str(error)) from error
        self.is_open = True

    def close(self) -> None:
        """End the bench; a second call does nothing."""
        runner, self._runner = self._runner, None
        self.is_open = False
        if runner is not None:
            runner.close()

    def _reconfigure_port(self) -> None:
        baud = self._baudrate
        self._there.do(lambda end: setattr(end.port, "baud", baud))

    @property
    def _there(self) -> Runner:
        if self._runner is None:
            raise PortNotOpenError
        return self._runner

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read at once."""
        return self._there.waiting

    @property
    def out_waiting(self) -> int:
        """Bytes written that are not out yet."""
        return self._there.pending

    def read(self, size: int = 1) -> bytes:
        """Read as pyserial does: so many bytes, or fewer when the timeout is over.

        Raises:
            SerialException: the bench has come to its end, and nothing is left to read.
        """
        runner = self._there
        data = runner.read(size, self._timeout)
        if not data and size and runner.failure:
            raise SerialException(runner.failure)
        return data

    def write(self, data: Any) -> int:
        """Put bytes on the line; return how many. Never waits.

        Raises:
            SerialException: the bench has come to its end.
        """
        runner, sent = self._there, to_bytes(data)
        if runner.failure:
            raise SerialException(runner.failure)
        runner.write(sent)
        return len(sent)

    def flush(self) -> None:
        """Wait until all is out that was written."""
        self._there.drain()

    def reset_input_buffer(self) -> None:
        """Forget what came and was not read."""
        self._there.discard()

    def reset_output_buffer(self) -> None:
        """Forget what is not on the line yet."""
        self._there.do(lambda end: end.port.withdraw(0))

    def cancel_read(self) -> None:
        """Have a read that waits return with what there is."""
        self._there.cancel()

    def _update_break_state(self) -> None:
        if self._break_state:
            self._there.do(_hold_low)

    def _update_rts_state(self) -> None:
        """Do nothing: no line is there."""

    def _update_dtr_state(self) -> None:
        """Do nothing: no line is there."""

    @property
    def cts(self) -> bool:
        """Always asserted."""
        self._there  # noqa: B018 - raises if the port is not open
        return True

    dsr = cd = cts

    @property
    def ri(self) -> bool:
        """Never asserted."""
        self._there  # noqa: B018 - raises if the port is not open
        return False


def _hold_low(end: NearEnd) -> None:
    end.port.send_break(_BREAK_NS)
