"""Most defects are put in by `make exhaustive` alone; that their words still stand in the model is seen at once."""

from __future__ import annotations

import importlib
from pathlib import Path

HERE = Path(__file__).parent


def test_each_defect_changes_what_there_is():
    modules = [importlib.import_module(f"{__package__}.{file.stem}") for file in sorted(HERE.glob("test_*.py"))]
    lists = [module.DEFECTS for module in modules if hasattr(module, "DEFECTS")]
    assert len(lists) >= 8
    for defect in (one for defects in lists for one in defects):
        assert defect.source().replace(defect.right, defect.wrong, 1) != defect.source(), defect
