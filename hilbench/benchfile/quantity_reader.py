"""Finds out what the quantities of parts are: signals of the world, or what other parts give.

A quantity that goes out leads to the world; one that comes in has its source in the world or in another part. Each
mistake is named with its line, and with what would fit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from hilbench.benchfile.bench_file import PartPlan, QuantityEnd
from hilbench.benchfile.bench_model import BenchModel, PartEntry, World
from hilbench.benchfile.order import CircleError, order_of
from hilbench.benchfile.world_signals import WorldSignal
from hilbench.nearest import did_you_mean
from hilbench.plugins.system import VehicleKind
from hilbench.strict import Path, Strict
from targets.parts import Direction, Part, Quantity

__all__ = ["WORLD", "QuantityReader"]

WORLD = "world"
_MOST_HINTS = 4
_NOT_PLANE = 'leave out physics = "plane"'


class QuantityReader:
    """Reads what stands under ``signals`` of the parts of one file.

    Args:
        model: the file as it is written.
        kinds: the class of each part.
        vehicle: the vehicle in its world; None for one of which nothing is known: its signals are not looked at.
        strict: says where in the file something stands.
    """

    def __init__(
        self, model: BenchModel, kinds: Mapping[str, type[Part]], vehicle: VehicleKind | None, strict: Strict
    ) -> None:
        self._model = model
        self._kinds = kinds
        self._strict = strict
        self._vehicle = vehicle
        self._signals: Mapping[str, WorldSignal] = {} if vehicle is None else vehicle.signals

    def read(self, name: str, entry: PartEntry) -> tuple[dict[str, str], dict[str, QuantityEnd]]:
        """Return the signals of the world and the quantities of other parts, by the quantities of a part.

        Raises:
            UsageError: a quantity or signal does not exist or does not fit, or one that is needed is missing.
        """
        quantities = {quantity.name: quantity for quantity in self._kinds[name].QUANTITIES}
        self._check_names(name, entry, quantities)
        signals: dict[str, str] = {}
        sources: dict[str, QuantityEnd] = {}
        for key, text in entry.signals.items():
            path: Path = ("parts", name, "signals", key)
            if text.partition(".")[0] in self._kinds:
                sources[key] = self._source(path, text, quantities[key])
            else:
                signals[key] = self._signal(path, text, quantities[key])
        return signals, sources

    def check(self, plans: Mapping[str, PartPlan], robot: str) -> None:
        """Let nothing in the world be driven by two, no part wait for itself, and the vehicle fit its physics.

        Raises:
            UsageError: the first of these that is broken.
        """
        if self._vehicle is not None:
            self._check_drivers(plans, robot)
        try:
            order_of(plans, self._kinds)
        except CircleError as circle:
            self._refuse_circle(circle.names, plans)
        world = self._model.world
        if any(plan.signals for plan in plans.values()) and not self._fits(world):
            message = f'physics "plane" has vehicles with two wheels, and no {world.vehicle}'
            raise self._strict.error(message, ("world", "physics"), _NOT_PLANE)

    def _check_names(self, name: str, entry: PartEntry, quantities: Mapping[str, Quantity]) -> None:
        terminals = [terminal.name for terminal in self._kinds[name].TERMINALS]
        path: Path = ("parts", name, "signals")
        for key in entry.signals:
            if key in terminals:
                raise self._strict.error(f"'{key}' is a terminal", (*path, key), f"put it under pins: {key} = ...")
            if key not in quantities:
                hint = did_you_mean(key, quantities, "its quantities") if quantities else "it has none"
                raise self._strict.error(f"a {entry.kind} has no quantity '{key}'", (*path, key), hint)
        for quantity in quantities.values():
            if quantity.needed and quantity.name not in entry.signals:
                message = f"'{name}': its quantity '{quantity.name}' ({quantity.text}) is nothing"
                fits = [f'"{one}"' for one in self._fitting(name, quantity)]
                hint = f"add signals = {{ {quantity.name} = {fits[0] if fits else '...'} }}"
                raise self._strict.error(message, ("parts", name), hint)

    def _signal(self, path: Path, text: str, quantity: Quantity) -> str:
        owner, _, name = text.partition(".")
        if self._vehicle is None and owner == WORLD:
            return name
        instead = self._instead(str(path[1]), quantity)
        if owner != WORLD or name not in self._signals:
            known = [f"{WORLD}.{name}" for name in self._signals]
            hint = did_you_mean(text, known) if owner == WORLD else instead
            raise self._strict.error(f"no signal '{text}'", path, hint)
        signal = self._signals[name]
        if signal.direction is not quantity.direction:
            way = "takes" if signal.direction is Direction.OUT else "gives"
            raise self._strict.error(f"'{text}' is what the world {way}", path, instead)
        self._check_unit(path, text, signal.unit, quantity, instead)
        if signal.by_rays and self._model.world.physics == "plane":
            message = f"'{text}': physics \"plane\" has no rays, and nothing would ever be seen"
            raise self._strict.error(message, path, f"under [world] {_NOT_PLANE}")
        return name

    def _source(self, path: Path, text: str, quantity: Quantity) -> QuantityEnd:
        part, _, name = text.partition(".")
        instead = self._instead(str(path[1]), quantity)
        if quantity.direction is Direction.OUT:
            message = f"'{path[-1]}' goes out, and '{text}' is no signal of the world"
            raise self._strict.error(message, path, f"write under [parts.{part}] where its '{name}' comes from")
        others = {one.name: one for one in self._kinds[part].QUANTITIES}
        if name not in others:
            known = [f"{part}.{one.name}" for one in others.values() if one.direction is Direction.OUT]
            raise self._strict.error(f"'{part}' has no quantity '{name}'", path, did_you_mean(text, known, "it gives"))
        if others[name].direction is Direction.IN:
            raise self._strict.error(f"'{text}' is what '{part}' takes", path, instead)
        self._check_unit(path, text, others[name].unit, quantity, instead)
        return QuantityEnd(part=part, quantity=name)

    def _check_unit(self, path: Path, text: str, unit: str, quantity: Quantity, instead: str) -> None:
        if unit != quantity.unit:
            raise self._strict.error(f"'{text}' is in {unit}, and this in {quantity.unit}", path, instead)

    def _instead(self, name: str, quantity: Quantity) -> str:
        fits = self._fitting(name, quantity)
        more = ", ..." if len(fits) > _MOST_HINTS else ""
        return f"it can be {', '.join(fits[:_MOST_HINTS])}{more}" if fits else "nothing on this bench fits"

    def _fitting(self, name: str, quantity: Quantity) -> list[str]:
        """What has the right direction and unit, as it is written."""
        wanted = quantity.direction, quantity.unit
        fits = [f"{WORLD}.{one.name}" for one in self._signals.values() if (one.direction, one.unit) == wanted]
        if quantity.direction is Direction.IN:
            fits += [
                f"{part}.{one.name}"
                for part, kind in self._kinds.items()
                for one in kind.QUANTITIES
                if part != name and one.direction is Direction.OUT and one.unit == quantity.unit
            ]
        return fits

    def _check_drivers(self, plans: Mapping[str, PartPlan], robot: str) -> None:
        drivers: dict[str, str] = {}
        for name, quantity, signal in _driven(plans, self._signals):
            path: Path = ("parts", name, "signals", quantity)
            if signal in drivers:
                message = f"{WORLD}.{signal} is driven by '{drivers[signal]}' already"
                raise self._strict.error(message, path, "take the other wheel, or leave one of the two parts out")
            if robot:
                message = f"{WORLD}.{signal} is driven by the controller of '{robot}'"
                raise self._strict.error(message, path, f"leave out [targets.{robot}], or this")
            drivers[signal] = name

    def _fits(self, world: World) -> bool:
        """Whether the physics can hold the vehicle."""
        if world.physics != "plane" or self._vehicle is None:
            return True
        body = self._vehicle.vehicle()
        return body.drive is not None or body.motion is not None

    def _refuse_circle(self, names: Sequence[str], plans: Mapping[str, PartPlan]) -> None:
        name = names[0]
        quantity = next(key for key, end in plans[name].sources.items() if end.part in names)
        way = " -> ".join([*names, name])
        message = f"{way}: each needs for a step what the next one gives for the same step"
        raise self._strict.error(message, ("parts", name, "signals", quantity), "leave one of these signals out")


def _driven(plans: Mapping[str, PartPlan], signals: Mapping[str, WorldSignal]) -> Iterable[tuple[str, str, str]]:
    """Part, quantity and signal of what drives the world."""
    for name, plan in plans.items():
        for quantity, signal in plan.signals.items():
            if signals[signal].direction is Direction.OUT:
                yield name, quantity, signal
