"""The side that a suite puts to the test, in any protocol: what a case asks of it, and our own that does it."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

from hilbench.judging.verdicts import Violation

__all__ = ["OwnUnderTest", "UnderTest"]


class _Connects(Protocol):
    def connect(self) -> None: ...

    def disconnect(self) -> None: ...


OwnT = TypeVar("OwnT", bound=_Connects)
OwnT_co = TypeVar("OwnT_co", covariant=True)


class UnderTest(Protocol[OwnT_co]):
    """Something that can be made to speak to its robot."""

    @property
    def own(self) -> OwnT_co | None:
        """Ours, which can be commanded and asked; None if it is a foreign one."""

    def start(self) -> None:
        """Have it speak to its robot, from scratch.

        Raises:
            UnavailableError: it cannot be started, or nobody came.
        """

    def ended(self) -> str:
        """Say how it ended by itself, as in "exited with status 3"; empty while it lives."""

    def disconnect(self) -> None:
        """Have its user end the session."""

    def close(self) -> None:
        """Make sure it is gone."""


class OwnUnderTest(Generic[OwnT]):
    """Our own, of this package.

    Args:
        own: what is tested.
        called: what a report calls it, as in "client".
        refusal: what it raises if it does not want to, as the protocol names it.
    """

    def __init__(self, own: OwnT, *, called: str, refusal: type[Exception]) -> None:
        self._own = own
        self._called = called
        self._refusal = refusal

    @property
    def own(self) -> OwnT:
        """What is tested itself."""
        return self._own

    def start(self) -> None:
        """Begin to connect.

        Raises:
            Violation: it does not want to.
        """
        try:
            self._own.connect()
        except self._refusal as error:
            raise Violation(f"the {self._called} does not begin: {error}") from error

    def ended(self) -> str:
        """Return nothing: it lives and dies with its bench."""
        return ""

    def disconnect(self) -> None:
        """Begin to take leave.

        Raises:
            Violation: it does not want to.
        """
        try:
            self._own.disconnect()
        except self._refusal as error:
            raise Violation(f"the {self._called} does not end cleanly: {error}") from error

    def close(self) -> None:
        """Nothing to do: it lives and dies with its bench."""
