"""Recordings of a simulator's line: the clauses that can be judged by listening alone."""

from __future__ import annotations

from hilbench.check import NotApplicable, Violation
from hilbench.check.capture_provider import CaptureCase
from hilbench.recordings.listening import HOST, TARGET
from hilbench.suites._recorded import around, on_recording, stretches_of

STATUS = "Status"


@on_recording("VS13")
def test_a_status_has_22_bytes(bench: CaptureCase) -> None:
    seen = 0
    for end in (TARGET, HOST):
        for stretch in stretches_of(bench, end):
            sent = stretch.by(end)
            statuses = sum(one.item.name == STATUS for one in sent)
            seen += statuses
            stray = next((one for one in sent if not one.sound and statuses and one is not sent[0]), None)
            if stray is not None:
                what = f"{len(stray.item.raw)} bytes between statuses ({stretch.at(stray.ns)})"
                raise Violation(what, around(stretch, stray.ns))
    if not seen:
        raise NotApplicable("there is no status in this recording")
