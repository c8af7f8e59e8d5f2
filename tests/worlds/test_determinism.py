"""The same steps give the same bits, however often, wherever and whatever is read in between."""

from __future__ import annotations

import textwrap

import pytest

from tests.rigid import BULLET
from worlds import bullet

PROGRAM = textwrap.dedent("""
    import hashlib, sys
    from worlds import open_world
    world = open_world("room-with-boxes", "pioneer-2dx", sys.argv[1], seed=5)
    digest = hashlib.sha256()
    for step in range(400):
        world.command("wheel_left", 4.0 + step / 200, 1.0)
        world.command("wheel_right", 5.0 - step / 300, 1.0)
        world.step()
        pose, velocity = world.pose(), world.velocity()
        digest.update(repr((pose, velocity, world.joint("wheel_left"))).encode())
    print(digest.hexdigest())
""")


def test_two_processes_agree_bit_for_bit(python, physics):
    runs = [python(PROGRAM, physics, PYTHONHASHSEED=seed) for seed in ("1", "2")]
    assert [run.returncode for run in runs] == [0, 0], runs
    assert len(runs[0].stdout) == 65
    assert runs[0].stdout == runs[1].stdout


@pytest.mark.parametrize("physics", [BULLET])
def test_a_reused_client_gives_the_bits_of_a_new_one(pioneer, run_hash, monkeypatch):
    monkeypatch.setattr(bullet, "_idle_clients", [])
    body = pioneer("wall")
    fresh = run_hash(body)
    body.world.close()
    assert bullet._idle_clients == [body.world._client]
    other = pioneer("ramp")
    run_hash(other, steps=50)
    other.world.close()
    again = pioneer("wall")
    assert again.world._client == body.world._client
    assert run_hash(again) == fresh


def test_two_worlds_at_once_do_not_meet(pioneer, run_hash):
    alone = run_hash(pioneer("wall"))
    neighbour = pioneer("wall")
    assert run_hash(pioneer("wall"), meanwhile=lambda _: neighbour.world.step()) == alone
    assert neighbour.world.pose().position_m[0] == pytest.approx(0.0, abs=1e-3)


def test_looking_changes_nothing(pioneer, run_hash):
    undisturbed = run_hash(pioneer("wall"))
    for what, meanwhile in (
        ("rays", lambda body: [body.sonar_range_m(number) for number in range(8)]),
        ("contacts", lambda body: body.world.contacts()),
        ("senses", lambda body: (body.bumpers(), body.motor_loads(), body.wheel_angles_rad())),
        ("a command overridden before it acts", lambda body: body.command_wheels(0.0, 0.0)),
    ):
        assert run_hash(pioneer("wall"), meanwhile=meanwhile) == undisturbed, what


def test_the_hash_would_show_a_difference(pioneer, run_hash):
    nudged = pioneer("wall")
    nudged.world.place(1e-9, 0.0, 0.0)
    assert run_hash(nudged) != run_hash(pioneer("wall"))
    assert run_hash(pioneer("wall"), steps=599) != run_hash(pioneer("wall"), steps=600)
