"""Links: how bytes get from one end to the other, inside the bench and to the outside world."""

from hilbench.links.memory import MemoryLink, MemoryPort
from hilbench.links.port import Line, LinkCounters, Port

__all__ = ["Line", "LinkCounters", "MemoryLink", "MemoryPort", "Port"]
