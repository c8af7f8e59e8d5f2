"""A build asks for a compiler from PyPI only where it needs one and there is none."""

from __future__ import annotations

from pathlib import Path

import pytest

from targets.mcu.core import build, sources
from targets.mcu.core.hatch_build import CoreBuildHook

ROOT = Path(__file__).parents[2]


@pytest.fixture
def hook(monkeypatch):
    monkeypatch.delenv("HILBENCH_WHEEL_MACHINE", raising=False)
    return lambda: CoreBuildHook(str(ROOT), {}, None, None, "", "wheel")


@pytest.mark.parametrize(
    ("compiled", "compiler", "machine", "asks"),
    [
        (True, None, "", False),
        (False, ["cc"], "", False),
        (False, None, "", True),
        (True, ["cc"], "aarch64", True),
    ],
)
def test_ziglang_is_asked_for_only_where_it_is_needed(hook, monkeypatch, compiled, compiler, machine, asks):
    monkeypatch.setattr(sources, "current", lambda *_: Path("lib.so") if compiled else None)
    monkeypatch.setattr(build, "find_compiler", lambda: compiler)
    monkeypatch.setenv("HILBENCH_WHEEL_MACHINE", machine)
    assert [name.partition(">")[0] for name in hook().dependencies()] == (["ziglang"] if asks else [])
