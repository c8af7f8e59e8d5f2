"""What a recording says of a head: the rules that need nobody to ask."""

from hilbench.check import NotApplicable, at_most, case
from hilbench.judging.provider import RECORDING
from hilbench.recordings.listening import HOST, TARGET
from pantilt.frames import IDS

ANSWER_S, PATIENCE_NS = 0.02, 100_000_000  # who has not answered by then does not


@case("PT1", needs={RECORDING})
def test_commands_are_answered(bench):
    asked = 0
    for stretch in bench.stretches:
        if TARGET not in stretch.under_test:
            continue
        answers = [(one.ns, one.item.fields.get("servo")) for one in stretch.by(TARGET)]
        for one in stretch.by(HOST):
            servo = one.item.fields.get("servo")
            if servo not in IDS.values() or not stretch.quiet(one.ns, one.ns + PATIENCE_NS):
                continue
            asked += 1
            after_ns = min([ns - one.ns for ns, who in answers if ns >= one.ns and who == servo], default=PATIENCE_NS)
            what = f"servo {servo} answered after ({stretch.at(one.ns)})"
            at_most(after_ns / 1e9, ANSWER_S, unit="s", what=what, uncertainty=stretch.uncertainty_s)
    if not asked:
        raise NotApplicable("nobody asks in this recording")
