"""The commands, one module each; `hilbench.cli` imports the one that is asked for."""

from __future__ import annotations
