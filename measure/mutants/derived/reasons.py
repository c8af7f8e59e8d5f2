"""Why a derived mutant survives, by family.

A reason begins with one of two words. "equivalent": the specification permits it, in a sentence that is named.
"unasked": it is wrong, but no clause asks for what would show it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from measure.mutants.derived.trial import Outcome

__all__ = ["EQUIVALENT", "REASONS", "reason"]

EQUIVALENT = "equivalent"

REASONS: Mapping[str, Sequence[tuple[str, str]]] = MappingProxyType({})
"""By subject: what the ids of a family match, and its reason; the first that matches counts."""

_CONSTANT = "unasked: in no case of the suites does the field have two values"
_NEVER = "unasked: no case of the suites has a frame with which it does anything else than the right peer"


def reason(subject: str, id_: str, outcome: Outcome) -> str:
    """Return why a mutant survives; empty if nobody knows."""
    for pattern, text in REASONS.get(subject, ()):
        if re.search(pattern, id_):
            return text
    if not outcome.cases:
        return _CONSTANT if id_.rpartition(":")[2] in ("stuck", "stale") else _NEVER
    return ""
