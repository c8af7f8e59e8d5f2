"""Imported at the start of each process of a copy's environment: records in those that a test has started."""

from __future__ import annotations

import os
from pathlib import Path

if os.environ.get("GATE_PROOF_CONTEXT"):
    from gate_tracer import CONTEXT, FOLDER, TREE, Child, Tracer

    Child(Tracer(Path(os.environ[TREE])), Path(os.environ[FOLDER]), Path(os.environ[CONTEXT]), forked_alone=False)
