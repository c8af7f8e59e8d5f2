"""Settings that a short run cannot show, seen in the calls themselves."""

from __future__ import annotations

import pytest

from tests.rigid import BULLET
from worlds.vehicles.pioneer_2dx import LEFT

pytestmark = pytest.mark.parametrize("physics", [BULLET])


class Spy:
    """Passes every call on to the library and keeps its name and keywords."""

    def __init__(self, library):
        self._library = library
        self.calls = []

    def __getattr__(self, name):
        found = getattr(self._library, name)
        if not callable(found) or isinstance(found, type):
            return found

        def call(*arguments, **keywords):
            self.calls.append((name, keywords))
            return found(*arguments, **keywords)

        return call


@pytest.fixture
def spy(open_it, monkeypatch):
    open_it("empty", "pioneer-2dx").close()  # so that the next world finds a client waiting
    from worlds import bullet

    spy = Spy(bullet._import())
    monkeypatch.setattr(bullet, "_import", lambda: spy)
    world = open_it("ramp", "pioneer-2dx")
    world.command(LEFT, 1.0, 1.0)
    world.step()
    world.pose(), world.velocity(), world.joint(LEFT), world.contacts(), world.contacts("caster")
    world.cast([(0, 0, 1)], [(1, 0, 1)])
    return spy


def test_every_call_names_its_client(spy):
    assert len(spy.calls) > 30
    assert [name for name, keywords in spy.calls if "physicsClientId" not in keywords] == []


def test_pairs_are_ordered_before_anything_is_loaded(spy):
    names = [name for name, _ in spy.calls]
    engine = names.index("setPhysicsEngineParameter")
    assert spy.calls[engine][1]["deterministicOverlappingPairs"] == 1
    assert spy.calls[engine][1]["fixedTimeStep"] == 1 / 240
    assert names.index("resetSimulation") < engine < names.index("createMultiBody") < names.index("loadURDF")


def test_every_surface_of_every_body_is_undamped(spy):
    surfaces = [keywords for name, keywords in spy.calls if name == "changeDynamics"]
    assert len(surfaces) == 1 + 2 + 6  # floor, slope and top, the robot's parts
    for keywords in surfaces:
        assert {keywords[name] for name in ("linearDamping", "angularDamping", "jointDamping")} == {0.0}


def test_rays_use_one_thread(spy):
    assert [keywords["numThreads"] for name, keywords in spy.calls if name == "rayTestBatch"] == [1]


def test_an_unchanged_command_is_not_sent_again(open_it, monkeypatch):
    world = open_it("empty", "pioneer-2dx")
    world._engine = spy = Spy(world._engine)
    for _ in range(5):
        world.command(LEFT, 1.0, 1.0)
        world.step()
    assert [name for name, _ in spy.calls].count("setJointMotorControlArray") == 1
