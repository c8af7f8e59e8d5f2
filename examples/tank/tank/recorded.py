"""What a recording says of a node: the rules that need nobody to ask."""

from hilbench.check import NotApplicable, at_most, case
from hilbench.judging.provider import RECORDING
from hilbench.recordings.listening import HOST, TARGET

ANSWER_S, PATIENCE_NS = 0.05, 200_000_000  # who has not answered by then does not


@case("TANK1", needs={RECORDING})
def test_read_is_answered(bench):
    asked = 0
    for stretch in bench.stretches:
        if TARGET not in stretch.under_test:
            continue
        answers = [one.ns for one in stretch.by(TARGET) if one.item.name == "Level"]
        for one in stretch.by(HOST):
            if one.item.name != "Read" or not stretch.quiet(one.ns, one.ns + PATIENCE_NS):
                continue
            asked += 1
            after_ns = min([ns - one.ns for ns in answers if ns >= one.ns], default=PATIENCE_NS)
            what = f"a level came after ({stretch.at(one.ns)})"
            at_most(after_ns / 1e9, ANSWER_S, unit="s", what=what, uncertainty=stretch.uncertainty_s)
    if not asked:
        raise NotApplicable("nobody asks in this recording")
