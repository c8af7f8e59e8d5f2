"""The Pioneer robots as a system: their controller as a model, their body, and what checks, drives and serves them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from hilbench.errors import UnavailableError, UsageError
from hilbench.plugins.system import API, ModelKind, System, VehicleKind

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.bench.served_targets import ServedTarget
    from hilbench.bench.shared import Shared
    from hilbench.benchfile.bench_file import BenchFile
    from hilbench.driving.rig import Rig
    from hilbench.judging.provider import BenchProvider
    from hilbench.links import Port
    from hilbench.plugins.dashboard import Dashboard
    from hilbench.systems.pioneer.robot import PioneerPlan, VirtualPioneer
    from hilbench.terminal.options import TargetChoice
    from worlds.world import World

__all__ = ["PIONEER", "VEHICLE"]

TARGET = "pioneer"
VEHICLE = "pioneer-2dx"

_BARE_SUBCLASS = "p2dx"
"""Whose sonar discs a body has that no controller sits in."""


def _two_dx() -> VehicleKind:
    from hilbench.systems.pioneer.robot import sonar_poses
    from hilbench.systems.pioneer.signals import PIONEER_SIGNALS, PioneerSignals
    from worlds.vehicles import pioneer_2dx

    def body(world: World) -> pioneer_2dx.Pioneer2dxBody:
        return pioneer_2dx.Pioneer2dxBody(world, sonar_poses=sonar_poses(_BARE_SUBCLASS))

    return VehicleKind(
        vehicle=pioneer_2dx.vehicle,
        body=body,
        signals=PIONEER_SIGNALS,
        wire=PioneerSignals,
        size_m=(0.44, 0.38),
    )


class Pioneer(System):
    """See the module."""

    api = API
    name = "pioneer"
    title = "Pioneer"
    summary = "a Pioneer robot behind its P2OS line, in its world"
    vehicles = MappingProxyType({VEHICLE: _two_dx})
    speakers = MappingProxyType({"robot": "target"})
    checkers = MappingProxyType({"server": "host"})

    def models(self) -> Mapping[str, ModelKind]:
        """See `System`."""
        from targets.robots.pioneer import RobotSettings
        from targets.robots.pioneer.hostbaud import RATES

        robot = ModelKind(
            settings=RobotSettings,
            protocol="P2OS",
            suites=("p2os-client", "p2os-server", "pioneer-motion"),
            rates=tuple(RATES),
            target=TARGET,
            has_body=True,
        )
        return {VEHICLE: robot}

    def provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
        """See `System`."""
        from hilbench.bench.target_choice import client_provider, only_choice
        from hilbench.benchfile.target_grammar import TargetKind, target_of
        from hilbench.systems.pioneer.provider import P2OS_SERVER, AttachedProvider, VirtualProvider

        if not choices:
            return VirtualProvider(shared)
        choice = only_choice(shared, choices)
        target = target_of(choice)
        if target.kind is TargetKind.MODEL and target.text == TARGET:
            return VirtualProvider(shared)
        if target.kind is TargetKind.SERIAL:
            return AttachedProvider(shared, target.text)
        return client_provider(shared, choice, P2OS_SERVER, TARGET)

    def board_provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider | None:
        """See `System`."""
        from hilbench.bench.target_choice import port_of_boards
        from hilbench.systems.pioneer.provider import AttachedProvider

        choice = port_of_boards(shared, choices)
        return None if choice is None else AttachedProvider(shared, choice.spec)

    def stand(self, bench: Bench, bench_file: BenchFile, line: Callable[[int], Port], *, seed: int) -> VirtualPioneer:
        """See `System`."""
        from hilbench.systems.pioneer.robot import VirtualPioneer, plan_of

        plan = plan_of(bench_file)
        return VirtualPioneer(bench, line(plan.settings.host_baud), plan, seed=seed)

    def served(self, bench_file: BenchFile, *, scene: str | None, baud: int | None, seed: int) -> ServedTarget:
        """See `System`."""
        from hilbench.bench.served_targets import HOST_LINE, ServedTarget
        from hilbench.systems.pioneer.robot import VirtualPioneer
        from worlds.errors import WorldError

        plan = _plan(bench_file, scene, baud)

        def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
            try:
                return VirtualPioneer(bench, ports[HOST_LINE], plan, seed=seed).close
            except WorldError as error:
                raise UnavailableError(str(error), where=f"scene {plan.scene}") from error

        return ServedTarget({HOST_LINE: plan.settings.host_baud}, make, "robot")

    def rig(self, bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
        """See `System`."""
        from hilbench.systems.pioneer.rig import model_rig

        return model_rig(bench, bench_file, seed)

    def attached_rig(self, bench: Bench, bench_file: BenchFile, ports: Mapping[str, str], *, seed: int) -> Rig:
        """See `System`."""
        from hilbench.systems.pioneer.rig import attached_rig

        return attached_rig(bench, bench_file, ports[""], seed)

    def scene(self, bench_file: BenchFile) -> str | None:
        """Put the Pioneer that comes with hilbench among boxes: for most of its checks it stands on an empty floor."""
        is_ours = bench_file.path is not None and bench_file.path.parent == Path(__file__).with_name("benches")
        has_things = bench_file.has_world and bench_file.world.physics != "plane"
        return "room-with-boxes" if is_ours and has_things and bench_file.world.scene == "empty" else None

    def dashboard(self) -> Dashboard:
        """See `System`."""
        from hilbench.systems.pioneer.dashboard import DASHBOARD

        return DASHBOARD


def _plan(bench_file: BenchFile, scene: str | None, baud: int | None) -> PioneerPlan:
    from hilbench.systems.pioneer.robot import plan_of

    plan = plan_of(bench_file)
    if scene is not None:
        plan = replace(plan, scene=scene)
    if baud is not None:
        try:
            plan = replace(plan, settings=replace(plan.settings, host_baud=baud))
        except ValueError as error:
            raise UsageError(str(error), where=f"--baud {baud}") from None
    return plan


PIONEER = Pioneer()
