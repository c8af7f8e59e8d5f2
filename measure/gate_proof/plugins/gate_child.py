"""Imported at the start of each process of a copy's environment: records in those that a test has started."""

from __future__ import annotations

import atexit
import os
from pathlib import Path

if os.environ.get("GATE_PROOF_CONTEXT"):
    from gate_tracer import CONTEXT, FOLDER, TREE, Child, Tracer, forks_tell

    _tracer = Tracer(Path(os.environ[TREE]))
    _places = Path(os.environ[FOLDER]), Path(os.environ[CONTEXT])
    atexit.register(Child(_tracer, *_places).write)
    forks_tell(_tracer, *_places)
