"""Ten million bytes into each role, whole chunks beside single bytes: same events, no exception, bounded memory.

Run by `make soak`. P2OS_SOAK_BYTES sets another amount, P2OS_SOAK_SEED another seed.
"""

from __future__ import annotations

import os
import random

import pytest

from measure.soak.both_ways import soak
from protocols.p2os import (
    ClientOptions,
    Command,
    CommandNumber,
    ConfigPacket,
    Connection,
    EncoderPacket,
    Identification,
    LocalProtocolError,
    Role,
    ServerOptions,
    Sip,
    SonarReading,
    SyncEcho,
    SyncError,
    encode_command,
    encode_frame,
    encode_packet,
)

BYTES = int(os.environ.get("P2OS_SOAK_BYTES", "10_000_000"))
SEED = int(os.environ.get("P2OS_SOAK_SEED", "1"))
CHUNK = 4096
MAX_HELD = 256

CLIENT_SAYS = [
    *(encode_frame(bytes((number,))) for number in (0, 1, 2)),
    encode_command(Command(CommandNumber.OPEN, 1)),
    encode_command(Command(CommandNumber.VEL, -200)),
    encode_command(Command(CommandNumber.SAY, b"\xfa\xfb\x06\xfa\xfb\x03\x00\x00\x00")),
    encode_command(Command(200, 1)),
]
SERVER_SAYS = [
    encode_packet(SyncEcho(number=0)),
    encode_packet(SyncEcho(number=1)),
    encode_packet(Identification(name="soak", subclass="p2dx")),
    encode_packet(SyncError()),
    encode_packet(ConfigPacket(name="soak")),
    encode_packet(EncoderPacket(left_ticks=-1, right_ticks=0xFBFA)),
    encode_packet(Sip(moving=True, sonars=(SonarReading(number=1, range_raw=0xFBFA),) * 8)),
]


HANDSHAKES = {Role.SERVER: [*CLIENT_SAYS[:4], *[CLIENT_SAYS[4]] * 3], Role.CLIENT: [*SERVER_SAYS[:3], SERVER_SAYS[4]]}


def chunks(chance, frames, handshake):
    """Chunks of noise, of good frames, of damaged frames, of headers that promise too much, and whole handshakes."""
    while True:
        kind = chance.random()
        if kind < 0.2:
            yield chance.randbytes(CHUNK)
        elif kind < 0.3:
            yield bytes(chance.choices(b"\xfa\xfb\x03\x00\xc8\xff", k=CHUNK))
        elif kind < 0.6:
            yield from handshake
        else:
            chunk = bytearray(b"".join(chance.choices(frames, k=CHUNK // 30)))
            for _ in range(chance.choice((0, 5, 100))):
                chunk[chance.randrange(len(chunk))] = chance.randrange(256)
            yield bytes(chunk)


def server():
    return Connection(Role.SERVER, ServerOptions(handshake_limit_s=5))


def client():
    return Connection(Role.CLIENT, ClientOptions(max_restarts=1000))


def connected(client, now_ns):
    """Make a client that is idle connect again."""
    try:
        return client.connect(now_ns)
    except LocalProtocolError:
        return []


@pytest.mark.parametrize(("make", "frames"), [(server, CLIENT_SAYS), (client, SERVER_SAYS)], ids=["server", "client"])
def test_ten_million_bytes(make, frames, say):
    chance = random.Random(SEED)
    whole, single = make(), make()

    def start_again(now_ns):
        if whole.role is Role.CLIENT:
            assert connected(whole, now_ns) == connected(single, now_ns)

    figures = soak(chance, chunks(chance, frames, HANDSHAKES[whole.role]), whole, single, BYTES, MAX_HELD, start_again)
    say(f"{whole.role.value}: {figures}; {len(whole.visits)} edges, seed {SEED}; {whole.counters}")
