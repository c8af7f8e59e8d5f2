"""What stands around the emulated boards of a bench: parts, models, a bare vehicle in its world."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.bench.served_targets import HOST_LINE, ServedTarget
from hilbench.benchfile.bench_file import BenchFile, Link, ModelTarget
from hilbench.errors import UnavailableError, UsageError
from hilbench.links import Line, MemoryLink, Port
from hilbench.mcu.buses import Buses
from hilbench.mcu.far_ends import FarEnds
from hilbench.mcu.group import MachineGroup
from hilbench.mcu.parts import Parts
from hilbench.mcu.seams import Machine
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.system import Standing, System
from worlds.errors import WorldError

if TYPE_CHECKING:
    from hilbench.bench.world_runner import WorldRunner
    from hilbench.mcu.bare_vehicle import BareVehicle
    from worlds.world import World

__all__ = ["Surroundings"]


class Surroundings:
    """See the module.

    Args:
        bench: whose time everything lives in.
        bench_file: what to build.
        group: who lets the chips run.
        machines: the chips, by board.
        far_ends: of the USARTs' lines.
        seed: of everything random.

    Raises:
        UnavailableError: the world cannot be opened.

    Attributes:
        model: the model that stands in the world, if the bench has one.
        world: the world, if anything stands in one.
        body: the vehicle in it.
        runner: who moves the world.
        parts: the parts.
        open_lines: the lines of models without a body that lead to the checker, by the model's end; `a` is ours.
    """

    def __init__(
        self,
        bench: Bench,
        bench_file: BenchFile,
        group: MachineGroup,
        machines: Mapping[str, Machine],
        far_ends: FarEnds,
        *,
        seed: int,
    ) -> None:
        self._bench = bench
        self._bench_file = bench_file
        self._far_ends = far_ends
        self._seed = seed
        self._undo = contextlib.ExitStack()
        self.model: Standing | None = None
        self.world: World | None = None
        self.body: Any = None
        self.runner: WorldRunner | None = None
        self.open_lines: dict[str, MemoryLink] = {}
        self.parts = Parts(bench, bench_file.parts, machines, bench_file.nets, seed=seed)
        Buses(bench, group, machines, self.parts, bench_file.parts)
        try:
            if bench_file.standing is not None:
                self._add_model(bench_file.standing)
            elif bench_file.has_world:
                self._add_vehicle()
        except WorldError as error:
            raise UnavailableError(str(error), where=f"scene {bench_file.world.scene}") from error
        for name, there in bench_file.targets.items():
            if not there.kind.has_body:
                self._add_device(name, there)
        self._join_parts()
        self.parts.power_on()

    def close(self) -> None:
        """Give the world back."""
        self._undo.close()

    def _add_model(self, there: ModelTarget) -> None:
        def line(baud: int) -> Port:
            found = (self._model_port(link, Line(baud=baud)) for link in self._bench_file.links)
            port = next(filter(None, found), None)
            return port or MemoryLink(self._bench.scheduler, Line(baud=baud), name="robot").b

        assert isinstance(there.owner, System)  # a protocol's device has no body
        self.model = checked(there.owner.stand, Standing)(self._bench, self._bench_file, line, seed=self._seed)
        self._undo.callback(self.model.close)
        self._join(self.model)

    def _add_device(self, name: str, there: ModelTarget) -> None:
        """Put a model without a body at the boards that its lines lead to; those that lead to the checker are open.

        Raises:
            UsageError: it is one that only the checker has.
        """
        joined: dict[str, Port] = {
            mine: port for link in self._bench_file.links for mine, port in self._board_of(link, name)
        }
        ends = {end for link in self._bench_file.links for end in link.ends if end.startswith(f"{name}.")}
        if not ends:
            return
        if there.kind.beside:
            raise UsageError(f"'{name}' is what the checker is, and is not at a line of a bench", where="links")
        for end in (one for one in self._bench_file.served_lines if one in ends):
            self.open_lines[end] = MemoryLink(self._bench.scheduler, Line(baud=0), name=end)  # its far end has the pace
            joined[end.rpartition(".")[2]] = self.open_lines[end].b
        if isinstance(there.owner, System):
            made = checked(there.owner.beside_boards, ServedTarget)(self._bench_file, seed=self._seed)
            self._undo.callback(made.make(self._bench, dict(self._ends_of(made, joined))))
        else:
            assert there.owner.device is not None
            DeviceActor(self._bench, there.owner.device.make(there.settings), joined[HOST_LINE], name=name)

    def _ends_of(self, made: ServedTarget, joined: Mapping[str, Port]) -> Iterator[tuple[str, Port]]:
        """All ends of a model, of which some lead to boards or to the checker, and the others nowhere."""
        for line, baud in made.lines.items():
            nowhere = MemoryLink(self._bench.scheduler, Line(baud=baud), name=line).b
            yield line, joined.get(line.rpartition(".")[2], nowhere)

    def _board_of(self, link: Link, name: str) -> Iterator[tuple[str, Port]]:
        """The line of a model that leads to a board by this link, if it does, and the board's far end."""
        for end, other in (link.ends, link.ends[::-1]):
            if end.startswith(f"{name}.") and other in self._far_ends:
                yield end.rpartition(".")[2], self._far_ends.reacting(other)

    def _add_vehicle(self) -> None:
        from hilbench.mcu.bare_vehicle import BareVehicle

        vehicle = BareVehicle(self._bench, self._bench_file.world, seed=self._seed)
        self._undo.callback(vehicle.close)
        self._join(vehicle)

    def _join(self, vehicle: Standing | BareVehicle) -> None:
        self.world, self.body, self.runner = vehicle.world, vehicle.body, vehicle.runner
        kind = PLUGINS.systems.vehicle(self._bench_file.world.vehicle)
        self.parts.join(vehicle.runner, partial(kind.wire, vehicle.body))

    def _join_parts(self) -> None:
        """Let parts be the far ends of USARTs; whatever a part hears it may answer at once."""
        for link in self._bench_file.links:
            ends = [end for end in link.ends if end in self._far_ends]
            parts = [name for end in link.ends if (name := end.partition(".")[0]) in self._bench_file.parts]
            if ends and parts:
                self.parts.attach(parts[0], self._far_ends.reacting(ends[0]))

    def _model_port(self, link: Link, line: Line) -> Port | None:
        """Return the model's end of a link that leads to it: that of a board's USART, or of a part."""
        if not any(end.endswith(".host") for end in link.ends):
            return None
        for end in link.ends:
            name = end.partition(".")[0]
            if end in self._far_ends:
                return self._far_ends.reacting(end)
            if name in self._bench_file.parts:
                memory = MemoryLink(self._bench.scheduler, line, name=end)
                self.parts.attach(name, memory.a)
                return memory.b
        return None
