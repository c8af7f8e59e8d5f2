"""The kinds of parts, and which of their events come all the time."""

from __future__ import annotations

import sys

from targets.parts import PARTS, ROUTINE, part_class


def test_what_comes_all_the_time_are_events_of_parts():
    for kind in PARTS:
        part_class(kind)
    names = {
        name for module in list(sys.modules) if module.startswith("targets.parts.") for name in dir(sys.modules[module])
    }
    assert names >= ROUTINE
