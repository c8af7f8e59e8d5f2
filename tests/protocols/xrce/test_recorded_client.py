"""A client that is not ours, as recorded: the agent answers it as it did then, byte for byte."""

from __future__ import annotations

from protocols.xrce import AgentOptions, AgentService, Framing, FramingOptions
from tests.each import each
from tests.protocols.xrce.recorded_client import SAMPLES, SESSION

_STEP_NS = 20_000_000


@each("size", [1, 7, 4096])
@each("framing", [Framing.SERIAL, Framing.EITHER])
def test_the_client_is_answered_as_it_was(size, framing):
    agent = AgentService(("line",), AgentOptions(frames=FramingOptions(framing=framing)))
    now_ns = 0
    for what, said, answer in SESSION:
        came = bytes.fromhex(said)
        wrote = [agent.receive("line", came[at : at + size], now_ns) for at in range(0, len(came), size)]
        wrote.append(agent.advance(now_ns))
        assert b"".join(data for part in wrote for _, data in part).hex() == answer, what
        now_ns += _STEP_NS
    assert not agent.held


def test_the_recording_has_the_samples_that_the_client_heard():
    (_, said, answer) = next(exchange for exchange in SESSION if exchange.what.startswith("WRITE_DATA"))
    for sample in SAMPLES:
        assert sample in bytes.fromhex(said)
        assert sample in bytes.fromhex(answer)
