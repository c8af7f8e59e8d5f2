"""Looks on after a case has failed: what was late, or came behind something else, shows itself then."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from hilbench.bench import Bench
from hilbench.bench.line_end import LineEnd
from hilbench.bench.line_evidence import in_order, in_words
from hilbench.clock import NS_PER_S
from hilbench.errors import HilbenchError

ASK_AFTER_S, LOOK_ON_S = 0.4, 1.2
"""When what is asked again, and how long all of it takes (choices): a message that is a second late is still seen."""

_LINES_SHOWN = 6


def look_on(bench: Bench, peers: Mapping[str, LineEnd]) -> list[str]:
    """Let time pass, and return what that shows as lines for a report; none if nobody is at a line.

    A target that goes away meanwhile is the business of the next case.

    Args:
        bench: whose time passes.
        peers: the checker's ends of the lines, by name.
    """
    if not peers:
        return []
    began_ns, marks = bench.now_ns, {name: peer.mark() for name, peer in peers.items()}
    with suppress(HilbenchError):
        if bench.scheduler.locked:  # something real may be driving
            for peer in peers.values():
                peer.stand_still()
        bench.run_for(ASK_AFTER_S)
        for peer in peers.values():
            peer.ask_again()
        bench.run_for(LOOK_ON_S - ASK_AFTER_S)
    many = len(peers) > 1
    news = in_order(
        (at_ns, f"{name:9} {words}" if many else words)
        for name, peer in peers.items()
        for at_ns, words in peer.news(marks[name], began_ns)
    )
    looked = f"looked on for {(bench.now_ns - began_ns) / NS_PER_S:.1f} s"
    return [f"{looked}:", *(in_words(*one) for one in news[:_LINES_SHOWN])] if news else [f"{looked}: nothing new came"]
