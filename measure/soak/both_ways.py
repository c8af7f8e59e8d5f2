"""A stream into two ends of one kind, whole chunks beside single bytes."""

from __future__ import annotations

import tracemalloc
from collections import Counter

MAX_GROWTH = 2_000_000


def soak(chance, chunks, whole, single, least, most_held, before=lambda now_ns: None):
    """Require the same events of both, bounded memory, and no exception; return the figures, in words.

    Args:
        chance: when the chunks come.
        chunks: without end.
        whole: gets them as they are.
        single: gets them byte by byte.
        least: so many bytes.
        most_held: an end may hold so many.
        before: called before each chunk.
    """
    now_ns, count, baseline = 0, Counter(), None
    tracemalloc.start()
    for chunk in chunks:
        now_ns += chance.choice((0, 10_000_000, 700_000_000, 3_000_000_000))
        before(now_ns)
        expected = whole.receive(chunk, now_ns)
        got = single.advance(now_ns)
        for byte in chunk:
            got += single.receive(bytes((byte,)), now_ns)
        assert got == expected
        assert single.state is whole.state
        count["held"] = max(count["held"], whole.held, single.held)
        count["events"] += len(expected)
        count["bytes"] += len(chunk)
        if baseline is None and count["bytes"] > least // 10:
            baseline = tracemalloc.get_traced_memory()[0]
        if count["bytes"] >= least:
            break
    growth = tracemalloc.get_traced_memory()[0] - (baseline or 0)
    tracemalloc.stop()
    assert whole.counters == single.counters
    assert count["held"] <= most_held
    assert growth < MAX_GROWTH
    return (
        f"{count['bytes']} bytes, {count['events']} events; at most {count['held']} bytes held, memory grew by "
        f"{growth} bytes after the first tenth"
    )
