"""Results that were appended, after a run that was killed while it wrote."""

from __future__ import annotations

from dataclasses import dataclass

from measure.appended import read


@dataclass(frozen=True)
class Result:
    name: str
    seconds: float


def test_a_line_that_was_cut_is_left_out(tmp_path):
    file = tmp_path / "results.jsonl"
    assert read(file, Result) == []
    file.write_text('{"name": "idle", "seconds": 1.5}\n{"name": "busy"}\n{"name": "bu')
    assert read(file, Result) == [Result("idle", 1.5)]
