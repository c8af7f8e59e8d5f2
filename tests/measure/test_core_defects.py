"""The errors that are put into what is in C: their words still stand there, each in one place."""

from __future__ import annotations

from measure.core_defects import DEFECTS
from targets.mcu.core.sources import SOURCES


def test_each_defect_changes_one_place():
    texts = {file: (SOURCES / file).read_text(encoding="utf-8") for file in {one.file for one in DEFECTS}}
    assert not [(one.name, one.file) for one in DEFECTS if texts[one.file].count(one.old) != 1]
