"""Bench time has one owner: no module of the product but `hilbench.clock` imports a clock of the host."""

from __future__ import annotations

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
CLOCKS = {"time", "datetime", "timeit", "sched"}
MAY_IMPORT_ONE = re.compile(rf"\b(import|from)\b[^\n#]*\b({'|'.join(CLOCKS)})\b")


def imported(file: Path) -> set[str]:
    names: set[str] = set()
    text = file.read_text().replace("\\\n", " ")
    if not MAY_IMPORT_ONE.search(text):
        return names
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module.partition(".")[0])
    return names


def test_only_the_clock_module_knows_the_hosts_time() -> None:
    files = [
        file for package in ("hilbench", "protocols", "targets", "worlds") for file in (ROOT / package).rglob("*.py")
    ]
    assert len(files) > 100
    users = {str(file.relative_to(ROOT)) for file in files if imported(file) & CLOCKS}
    assert users == {"hilbench/clock/host.py"}
