"""What a recording says of a node: the rules that need nobody to ask."""

from hilbench.check import NotApplicable, Violation, case
from hilbench.judging.provider import RECORDING
from hilbench.recordings.listening import HOST, TARGET

ANSWER_NS = 50_000_000


@case("TANK1", needs={RECORDING})
def test_read_is_answered(bench):
    asked = 0
    for stretch in bench.stretches:
        if TARGET not in stretch.under_test:
            continue
        answers = [one.ns for one in stretch.by(TARGET) if one.item.name == "Level"]
        for one in stretch.by(HOST):
            last_ns = one.ns + ANSWER_NS + round(stretch.uncertainty_s * 1e9)
            if one.item.name != "Read" or not stretch.quiet(one.ns, last_ns):
                continue
            asked += 1
            if not any(one.ns <= ns <= last_ns for ns in answers):
                raise Violation(f"no level within 50 ms ({stretch.at(one.ns)})")
    if not asked:
        raise NotApplicable("nobody asks in this recording")
