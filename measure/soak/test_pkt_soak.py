"""A million bytes into each role of PKT!, whole beside byte by byte: same events, no exception, bounded memory.

Run by `make soak`. PKT_SOAK_BYTES sets another amount for each profile and role, PKT_SOAK_SEED another seed.
"""

from __future__ import annotations

import faulthandler
import os
import random
import tracemalloc

import pytest

from protocols.pkt import (
    LINE_LIMIT,
    PROFILES,
    Connection,
    GeneralReport,
    Role,
    UnknownCommand,
    encode_command,
    encode_frame,
    encode_report,
)

BYTES = int(os.environ.get("PKT_SOAK_BYTES", "1_000_000"))
SEED = int(os.environ.get("PKT_SOAK_SEED", "1"))
CHUNK = 4096
MAX_HELD = LINE_LIMIT
MAX_GROWTH = 2_000_000


def frames_for(profile, role):
    """Sound frames as this end gets them, and some that promise too much."""
    options = PROFILES[profile].server
    payloads = [encode_command(UnknownCommand(opcode=n, parameters=bytes(range(12)))) for n in range(256)]
    if role is Role.CLIENT:
        payloads = [encode_report(GeneralReport(accepted=n), options.schema) for n in range(256)]
        payloads += [bytes((n,)) + bytes(range(59)) for n in (0x82, 0x83, 0x84)]
    return [encode_frame(payload, options.frames) for payload in payloads]


def chunks(chance, frames):
    """Chunks of noise, of good frames, of damaged frames, of sync words without a frame."""
    while True:
        kind = chance.random()
        if kind < 0.2:
            yield chance.randbytes(CHUNK)
        elif kind < 0.4:
            yield bytes(chance.choices(b"PKT!PKT!\n\x01\x60\xff", k=CHUNK))
        elif kind < 0.5:
            yield b"".join(chance.choices([b"PKT!", b"PKT!\x60", b"P", b"\n"], k=CHUNK // 4))
        else:
            chunk = bytearray(b"".join(chance.choices(frames, k=CHUNK // 20)))
            for _ in range(chance.choice((0, 5, 100))):
                chunk[chance.randrange(len(chunk))] = chance.randrange(256)
            yield bytes(chunk)


def end_of(profile, role):
    connection = Connection(role, PROFILES[profile].server if role is Role.SERVER else PROFILES[profile].client)
    if role is Role.CLIENT:
        connection.connect(0)
    return connection


@pytest.mark.parametrize("role", list(Role), ids=lambda role: role.value)
@pytest.mark.parametrize("profile", PROFILES)
def test_a_million_bytes(profile, role, capsys):
    chance = random.Random(SEED)
    whole, single = end_of(profile, role), end_of(profile, role)
    now_ns = received = events_seen = longest_held = 0
    tracemalloc.start()
    baseline = None
    faulthandler.cancel_dump_traceback_later()  # it takes minutes, and is not stuck
    for chunk in chunks(chance, frames_for(profile, role)):
        now_ns += chance.choice((0, 10_000_000, 700_000_000, 3_000_000_000))
        expected = whole.receive(chunk, now_ns)
        got = single.advance(now_ns)
        for byte in chunk:
            got += single.receive(bytes((byte,)), now_ns)
        assert got == expected
        assert single.state is whole.state
        longest_held = max(longest_held, whole.held, single.held)
        events_seen += len(expected)
        received += len(chunk)
        if baseline is None and received > BYTES // 10:
            baseline = tracemalloc.get_traced_memory()[0]
        if received >= BYTES:
            break
    growth = tracemalloc.get_traced_memory()[0] - (baseline or 0)
    tracemalloc.stop()
    assert whole.counters == single.counters
    assert longest_held <= MAX_HELD
    assert growth < MAX_GROWTH
    figures = (
        f"{profile} {role.value}: {received} bytes, {events_seen} events, {len(whole.frame_visits)} edges of its "
        f"decoder, seed {SEED}; at most {longest_held} bytes held, memory grew by {growth} bytes after the first tenth"
    )
    with capsys.disabled():
        print(f"\n{figures}")  # noqa: T201 - the figures are what one runs it for
