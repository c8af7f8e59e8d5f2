"""What a P2OS client must do: every conformance case that a program which drives a robot can be put to.

The far end is a scripted server. The cases judge what the client sends; where it can be asked, also what it understood.
The limits are those of the clauses; where a clause has none, the constant that stands for it says where it comes from.
"""

from __future__ import annotations

ORDER = ("handshake", "packets", "config", "losses", "pose", "commands", "recorded")
