"""A million bytes into each role of PKT!, whole beside byte by byte: same events, no exception, bounded memory.

Run by `make soak`. PKT_SOAK_BYTES sets another amount for each profile and role, PKT_SOAK_SEED another seed.
"""

from __future__ import annotations

import os
import random

import pytest

from measure.soak.both_ways import soak
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
def test_a_million_bytes(profile, role, say):
    chance = random.Random(SEED)
    whole, single = end_of(profile, role), end_of(profile, role)
    figures = soak(chance, chunks(chance, frames_for(profile, role)), whole, single, BYTES, MAX_HELD)
    edges = f"{len(whole.frame_visits)} edges of its decoder"
    say(f"{profile} {role.value}: {figures}; {edges}, seed {SEED}")
