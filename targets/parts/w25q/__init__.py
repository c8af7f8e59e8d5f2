"""A W25Q serial NOR flash. Start at `w25q.py`."""

from targets.parts.w25q.w25q import W25q

__all__ = ["W25q"]
