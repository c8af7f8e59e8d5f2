"""What holds for the catalogue of every protocol, and for the package around it."""

from __future__ import annotations

import subprocess
import sys

HEAVY = {"mujoco", "numpy", "pybullet", "serial", "asyncio", "socket", "threading", "hilbench", "msgspec", "rich"}


def check_clauses(clauses, needs):
    """Hold each clause to be whole, and to ask only for what there is."""
    for clause in clauses:
        assert clause.level in ("must", "should"), clause.id
        assert clause.title, clause.id
        assert not clause.title.endswith("."), clause.id
        assert clause.text.endswith("."), clause.id
        assert clause.source, clause.id
        assert all(clause.sources), clause.id
        assert set(clause.needs) <= needs, clause.id


def check_package(package):
    """Hold a package to export what it says, and to bring nothing heavy along."""
    assert sorted(set(package.__all__)) == sorted(package.__all__)
    for name in package.__all__:
        assert getattr(package, name) is not None
    code = f"import sys, {package.__name__}; print(*sorted({{name.partition('.')[0] for name in sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert not loaded & HEAVY
    assert loaded >= {"protocols"}
