"""What a recording says of a head: the rules that need nobody to ask."""

from hilbench.check import NotApplicable, Violation, case
from hilbench.judging.provider import RECORDING
from hilbench.recordings.listening import HOST, TARGET
from pantilt.frames import IDS

ANSWER_NS = 20_000_000


@case("PT1", needs={RECORDING})
def test_commands_are_answered(bench):
    asked = 0
    for stretch in bench.stretches:
        if TARGET not in stretch.under_test:
            continue
        answers = [(one.ns, one.item.fields.get("servo")) for one in stretch.by(TARGET)]
        for one in stretch.by(HOST):
            servo, last_ns = one.item.fields.get("servo"), one.ns + ANSWER_NS + round(stretch.uncertainty_s * 1e9)
            if servo not in IDS.values() or not stretch.quiet(one.ns, last_ns):
                continue
            asked += 1
            if not any(one.ns <= ns <= last_ns and who == servo for ns, who in answers):
                raise Violation(f"servo {servo} does not answer within 20 ms ({stretch.at(one.ns)})")
    if not asked:
        raise NotApplicable("nobody asks in this recording")
