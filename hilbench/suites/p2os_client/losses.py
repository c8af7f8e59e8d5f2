"""The end of a session that the client did not want."""

from __future__ import annotations

import pytest

from hilbench.check import Untimely, at_most, case
from hilbench.clock import NS_PER_S
from hilbench.suites._client import CONNECT_WITHIN_S, ClientBench, begin, connect, require_lost, require_session
from protocols.p2os import ControllerReset, encode_packet

LOSS_WITHIN_S = 10.0
"""How long a client may take a silent robot for alive; clause C19 has it."""

NOTICED_S = 2.0
"""How long a client may take to report a reset, by which alone it is told: no SIP, no echo. A choice, far below C19."""


@case("C19", bench_time_s=23.8)
def test_a_dead_robot_is_noticed(bench: ClientBench) -> None:
    """It must not take a robot for dead, either, whose SIPs come all the time."""
    server = bench.server
    connect(bench)
    require_session(bench, LOSS_WITHIN_S + 0.5, "SIPs came all the time")
    silent_since_ns = server.last_sip_ns
    server.stream = lambda _tick: b""
    own = bench.client.own
    if own is not None:
        if not server.wait(lambda: bool(own.failure), LOSS_WITHIN_S + 0.5):
            raise Untimely(f"the client does not report within {LOSS_WITHIN_S:g} s that no SIP came", spare_s=0.5)
        elapsed_s = (bench.bench.now_ns - silent_since_ns) / NS_PER_S
        doubt_s = server.uncertainty_s(silent_since_ns)
        at_most(elapsed_s, LOSS_WITHIN_S, unit="s", what="loss declared after the last SIP by", uncertainty=doubt_s)
    server.run(max(0.0, LOSS_WITHIN_S - (bench.bench.now_ns - silent_since_ns) / NS_PER_S))
    require_lost(bench, f"no SIP came for {LOSS_WITHIN_S:g} s")


@case("C20", bench_time_s=4.3)
@pytest.mark.parametrize("configured", [True, False], ids=["configured", "waiting-for-config"])
def test_a_controller_reset_ends_the_session(bench: ClientBench, configured: bool) -> None:
    server = bench.server
    if configured:
        connect(bench)
    else:
        server.answer("CONFIG")
        begin(bench)
        server.expect_session(CONNECT_WITHIN_S)
    server.run(0.5)
    assert server.in_session, "the client closed its session although nothing had happened yet"
    server.stream = lambda _tick: b""
    server.write(encode_packet(ControllerReset()))
    own = bench.client.own
    if own is not None and not server.wait(lambda: bool(own.failure), NOTICED_S):
        text = f"the client does not report within {NOTICED_S:g} s that the controller was reset"
        raise Untimely(text, server.evidence(), spare_s=NOTICED_S / 2)
    server.end_session()
    server.run(0.5)
    require_lost(bench, "the controller was reset")
