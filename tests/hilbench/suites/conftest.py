"""What tests of several suites require of a report."""

from __future__ import annotations

from collections import Counter

import pytest


@pytest.fixture(scope="session")
def require_declared_times():
    """Require that clauses of reports took as long as the cases of its suites say they do, within a tenth."""

    def require(clauses, cases):
        declared_s = Counter()
        for case in cases:
            declared_s[case.clauses[0].id] += case.bench_time_s
        measured_s = {clause.id: clause.bench_time_s for clause in clauses}
        assert measured_s == pytest.approx(dict(declared_s), rel=0.1)

    return require
