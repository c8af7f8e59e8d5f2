"""What an agent on a bench is set to: every value with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

__all__ = ["AgentSettings", "ClientSettings"]

_LONGEST_S = 0x7FFFFFFF  # protocols.xrce.options.LONGEST_S, which takes its time


def _setting(default: Any, unit: str, source: str) -> Any:
    return field(default=default, metadata={"unit": unit, "source": source})


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSettings:
    """The agent. The defaults are what micro-ROS expects.

    Raises:
        ValueError: a value makes no agent. The message begins with the name of the setting.
    """

    references: str = _setting("", "", "XML of the profiles that clients refer to, as eProsima's agent.refs; none")
    silence_s: float | None = _setting(
        None, "s", "none: a client that is silent for longer is lost; eProsima's agent keeps it for ever"
    )
    epoch_s: float | None = _setting(
        None, "s", "what the agent's clock says at bench time 0; none: the host's when it is served, else 0"
    )
    history: int = _setting(16, "", "choice: samples that are kept for a reader that has not asked for them yet")
    max_objects: int = _setting(256, "", "choice: objects of one client")
    types: tuple[str, ...] = field(
        default=(),
        metadata={
            "unit": "folders",
            "source": "with definitions of types for the dashboard, PACKAGE/msg/NAME.msg in it; none: the usual ones",
            "folders": True,
        },
    )

    def __post_init__(self) -> None:
        """Checks the figures."""
        for name in ("silence_s", "history", "max_objects"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ValueError(f"{name} {value} is not above 0")
        if self.silence_s is not None and not self.silence_s <= _LONGEST_S:
            raise ValueError(f"silence_s {self.silence_s} is not at most {_LONGEST_S} s")
        if self.epoch_s is not None and not 0 <= self.epoch_s <= _LONGEST_S:
            raise ValueError(f"epoch_s {self.epoch_s} is not 0..{_LONGEST_S} s")
        if self.references:
            self._check_references()

    def _check_references(self) -> None:
        from protocols.xrce import LocalProtocolError, Profiles  # takes its time

        try:
            Profiles(self.references)
        except LocalProtocolError as error:
            raise ValueError(str(error)) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientSettings:
    """A board with micro-ROS that finds its agent again.

    Raises:
        ValueError: a value makes no client. The message begins with the name of the setting.
    """

    retry_s: float = _setting(
        1.0, "s", "Micro-XRCE-DDS-Client, UCLIENT_MIN_SESSION_CONNECTION_INTERVAL: between requests for a session"
    )
    quiet_s: float = _setting(0.5, "s", "choice: silence after which the agent is asked whether the session is there")
    lost_s: float = _setting(3.0, "s", "choice: silence after which the agent counts as lost")

    def __post_init__(self) -> None:
        """Checks the figures."""
        for name in ("retry_s", "quiet_s", "lost_s"):
            if not 0 < getattr(self, name) <= _LONGEST_S:
                raise ValueError(f"{name} {getattr(self, name)} is not above 0 s and at most {_LONGEST_S} s")
