"""A million random bytes into each role of the simulator's line: no exception, bounded memory, and how many it
believed.

Run by `make soak`. CARLA_SOAK_BYTES sets another amount for each profile and role, CARLA_SOAK_SEED another seed.
"""

from __future__ import annotations

import os
import random
import tracemalloc

import pytest

from protocols.carla import NOISE_RUN, PROFILES, VECTORS, Connection, Role

BYTES = int(os.environ.get("CARLA_SOAK_BYTES", "1_000_000"))
SEED = int(os.environ.get("CARLA_SOAK_SEED", "1"))
CHUNK = 500
MAX_HELD = NOISE_RUN + 30 + 4096 + CHUNK
MAX_GROWTH = 500_000
STEP_NS = 50_000_000
SOUND = {Role.BOARD: VECTORS["F5"].data, Role.SIMULATOR: VECTORS["F1"].data}


@pytest.mark.parametrize("role", list(Role), ids=lambda role: role.value)
@pytest.mark.parametrize("profile", PROFILES)
def test_a_million_random_bytes(profile, role, say):
    ends, chance = PROFILES[profile], random.Random(SEED)
    connection = Connection(role, ends.board if role is Role.BOARD else ends.simulator)
    now_ns = received = longest_held = 0
    tracemalloc.start()
    baseline = None
    while received < BYTES:
        now_ns += STEP_NS
        connection.receive(chance.randbytes(CHUNK), now_ns)
        connection.advance(now_ns)
        longest_held = max(longest_held, connection.held)
        received += CHUNK
        if baseline is None and received > BYTES // 10:
            baseline = tracemalloc.get_traced_memory()[0]
    growth = tracemalloc.get_traced_memory()[0] - (baseline or 0)
    tracemalloc.stop()
    believed = connection.counters.frames_in
    assert longest_held <= MAX_HELD
    assert growth < MAX_GROWTH
    if profile == "hardened":
        assert believed == 0
    now_ns += 60_000_000_000  # a poll has read all by then
    connection.advance(now_ns)
    for _ in range(3):
        now_ns += 100_000_000
        connection.receive(SOUND[role], now_ns)
    connection.advance(now_ns + STEP_NS)
    afterwards = connection.counters.frames_in - believed
    assert afterwards >= (2 if profile == "hardened" or role is Role.SIMULATOR else 0)
    figures = (
        f"{profile} {role.value}: {received} bytes, {believed} frames believed, seed {SEED}; at most "
        f"{longest_held} bytes held, memory grew by {growth} bytes after the first tenth; {afterwards} of 3 sound "
        f"frames believed behind them"
    )
    say(figures)
