"""What a micro-ROS agent on a bench of a vehicle interface is set to."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

__all__ = ["MicroRosSettings"]

_MOST_DOMAIN = 232
_MOST_AGENTS = 4


def _setting(default: Any, unit: str, source: str) -> Any:
    return field(default=default, metadata={"unit": unit, "source": source})


@dataclass(frozen=True, slots=True, kw_only=True)
class MicroRosSettings:
    """The agent between a board with micro-ROS and its driving stack, with the stack's node beside it.

    Raises:
        ValueError: a value makes no agent. The message begins with the name of the setting.
    """

    domain_id: int = _setting(0, "", "of the driving stack's node, as ROS_DOMAIN_ID; micro-ROS's default is 0")
    silence_s: float = _setting(1.0, "s", "choice: a board that says nothing for so long is lost, as on the other link")
    slow_s: float = _setting(0.0, "s", "fault: all that the agent says comes so much later")
    agents: int = _setting(1, "", "fault: how many agents are at the line; each says all that one would")

    def __post_init__(self) -> None:
        """Checks the figures."""
        if not 0 <= self.domain_id <= _MOST_DOMAIN:
            raise ValueError(f"domain_id {self.domain_id} is not 0..{_MOST_DOMAIN}")
        if not 0 < self.silence_s <= 1000:
            raise ValueError(f"silence_s {self.silence_s} is not above 0 s and at most 1000 s")
        if not 0 <= self.slow_s <= 1000:
            raise ValueError(f"slow_s {self.slow_s} is not 0..1000 s")
        if not 1 <= self.agents <= _MOST_AGENTS:
            raise ValueError(f"agents {self.agents} is not 1..{_MOST_AGENTS}")
