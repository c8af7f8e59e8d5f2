"""``python -m measure.xrce_messages``: reliable samples from client to client through the agent, on lines with faults.

Each sample has its number in it. That all arrive, once and in order, is required; what it takes is printed. Then random
and mutated bytes go into the agent and into a client, which may raise nothing and hold no more than they may.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Sequence

from protocols import xrce
from protocols.testing import lossy
from tests.protocols.xrce.star import MS, Star
from tests.protocols.xrce.test_service_fuzz import hear

FAULTS = {
    "a sound line": {},
    "writes cut short": {"drop": 0.05},
    "bits turned": {"flip": 0.05},
    "writes twice": {"repeat": 0.1},
    "noise between": {"noise": 0.2},
    "all of these": {"drop": 0.02, "flip": 0.02, "repeat": 0.05, "noise": 0.1},
}
SIZE = 20
PATIENCE_NS = 100_000 * 1000 * MS
LONGEST_HELD = 400_000


def exchange(count: int, seed: int, **fault: float) -> Star:
    """Send so many samples from one client to the other, as fast as there is room; all arrive once, in order."""
    star = Star("a", "b", mtu=512)
    star.connect()
    for name in ("a", "b"):
        star.create_all(name)
    star.read("b")
    star.damage = lossy(seed, **fault)
    sent = heard = 0
    end_ns = star.now_ns + PATIENCE_NS
    while heard < count:
        assert star.now_ns < end_ns, f"{heard} of {count} after {PATIENCE_NS / 1e9} s"
        try:
            while sent < count and star.clients["a"].unacknowledged < 12:
                star.write("a", sent.to_bytes(4, "big") * (SIZE // 4))
                sent += 1
        except xrce.StreamFullError:
            pass
        star.run(10 * MS)
        for data in star.data("b"):
            assert data == heard.to_bytes(4, "big") * (SIZE // 4), f"{data.hex()} where {heard} was to come"
            heard += 1
        star.heard["b"].clear()
        star.agent.take_events()
        assert star.agent.held < LONGEST_HELD
    return star


def flood(count: int) -> None:
    """Put so many random and mutated bytes into a client; the agent gets mutated conversations."""
    chance = random.Random(26)
    client = xrce.Session(xrce.Role.CLIENT, xrce.ClientOptions(client_key=b"\1\2\3\4"))
    heard = now_ns = 0
    frames = [
        xrce.encode_frame(
            xrce.encode_message(xrce.Header(session_id=0x81, stream_id=stream), xrce.encode_submessage(one))
        )
        for stream in (0, 1, 0x80)
        for one in (
            xrce.StatusAgent(status=xrce.Status.OK, agent=xrce.Agent()),
            xrce.TopicData(request_id=1, object_id=0x16, data=bytes(30)),
            xrce.Heartbeat(first_unacked=0, last_unacked=3, stream_id=0x80),
            xrce.AckNack(first_unacked=0, nack_bitmap=1, stream_id=0x80),
        )
    ]
    while heard < count:
        data = bytearray(chance.choice(frames) if chance.random() < 0.7 else chance.randbytes(40))
        if chance.random() < 0.5:
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        now_ns += chance.randrange(100 * MS)
        if client.state is xrce.ClientState.CLOSED:
            client.connect(now_ns)
        client.receive(bytes(data), now_ns)
        heard += len(data)
        assert client.held < LONGEST_HELD


def main(words: Sequence[str]) -> int:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m measure.xrce_messages", description=__doc__)
    parser.add_argument("--messages", type=int, default=1_000_000, help="in all (default: a million)")
    parser.add_argument("--bytes", type=int, default=10_000_000, help="random and mutated ones (default: ten million)")
    chosen = parser.parse_args(words)
    each = -(-chosen.messages // len(FAULTS))
    for seed, (what, fault) in enumerate(FAULTS.items()):
        began = time.process_time()
        star = exchange(each, seed, **fault)
        cpu_us = (time.process_time() - began) * 1e6 / each
        repeated = sum(one.counters.repeated for one in (*star.clients.values(), *star.agent.sessions.values()))
        _tell(f"{what}: {each} samples, {repeated} messages repeated, {cpu_us:.0f} us of CPU for each")
    flood(chosen.bytes // 2)
    rounds = 0
    agent_bytes = 0
    while agent_bytes < chosen.bytes // 2:
        agent = hear(1000 + rounds, 20_000)
        agent_bytes += sum(session.counters.bytes_in for session in agent.sessions.values())
        rounds += 1
    _tell(f"{chosen.bytes // 2} bytes into a client, {agent_bytes} into an agent: nothing raised")
    return 0


def _tell(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
