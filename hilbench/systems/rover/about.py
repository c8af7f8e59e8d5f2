"""What the header of a journal says of a rover for those who show it; see `hilbench.bench.about`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hilbench.bench.about import about_line
from hilbench.bench.state_reporter import Observed

__all__ = ["about_pkt"]


def about_pkt(operator: str, machines: Mapping[str, Observed], profile: str) -> dict[str, Any]:
    """Return what `about_line` does of PKT!, and how its frames are made in a profile."""
    from protocols.pkt import PROFILES

    server = PROFILES[profile].server
    about = about_line(operator, "pkt", machines)
    return about | {"framing": server.frames.framing.name, "schema": server.schema.name, "profile": profile}
