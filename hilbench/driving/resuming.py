"""A session that a lost line has ended is begun again when the line comes back."""

from __future__ import annotations

from hilbench.driving.operators import Operator
from hilbench.links import Port

__all__ = ["resume_sessions"]


def resume_sessions(port: Port, operator: Operator) -> None:
    """Have an operator connect again when its line comes back, if it was connected, or trying to, when it went.

    Args:
        port: the operator's end of the line; its owner has set its callbacks.
        operator: who was in session.
    """
    to_client = port.on_line
    wanted = False

    def line_changed(up: bool, at_ns: int) -> None:
        nonlocal wanted
        if not up:
            wanted = not operator.idle
        to_client(up, at_ns)
        if up and wanted:
            operator.connect()

    port.on_line = line_changed
