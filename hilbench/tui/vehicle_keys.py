"""What is asked of a bench with a vehicle interface: modes, the joystick's switch, who falls silent, lamps."""

from __future__ import annotations

from textual.binding import Binding, BindingType

from hilbench.tui.bench_process import BenchProcess
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.recorded import RecordedBench

__all__ = ["VEHICLE_BY_NAME", "VEHICLE_KEYS", "VEHICLE_NEEDS", "VehicleActions"]

VEHICLE_KEYS: list[BindingType] = [
    Binding("y", "ask_autoware", "AUTOWARE", show=False),
    Binding("v", "ask_manual", "MANUAL", show=False),
    Binding("j", "press_switch", "Switch"),
    Binding("k", "stack", "Stack"),
    Binding("l", "simulator", "Simulator"),
    Binding("z", "lamps", "Lamps", show=False),
    Binding("backspace", "restart", "Back to the start", show=False),
]

VEHICLE_BY_NAME = {
    "ask_autoware": "Ask the board for AUTOWARE",
    "ask_manual": "Ask the board for MANUAL",
    "press_switch": "Press the joystick's switch",
    "stack": "Pause the driving stack, or let it go on",
    "simulator": "Pause the simulator, or let it go on",
    "lamps": "Next lamps: left, right, hazard, off",
    "restart": "Put the car back to the start",
}

VEHICLE_NEEDS = {
    "ask_autoware": "mode", "ask_manual": "mode", "press_switch": "press", "stack": "stack", "simulator": "simulator",
    "lamps": "lamps", "restart": "restart",
}  # fmt: skip

_LAMPS = ("off", "left", "right", "hazard")


class VehicleActions:
    """The actions; mixed into the dashboard."""

    process: BenchProcess | RecordedBench
    model: BenchModel | None
    lamps_asked = 0

    def action_ask_autoware(self) -> None:
        """Have the driving stack ask the board for AUTOWARE; it drives then."""
        self.process.send("mode", mode="AUTOWARE")

    def action_ask_manual(self) -> None:
        """Have the driving stack ask the board for MANUAL; the joystick rules then."""
        self.process.send("mode", mode="MANUAL")

    def action_press_switch(self) -> None:
        """Press the joystick's switch: AUTOWARE becomes MANUAL, and MANUAL AUTOWARE."""
        self.process.send("press")

    def action_stack(self) -> None:
        """Let the driving stack fall silent, commands, clock and answers, or let it go on."""
        self.process.send("stack", on=not self._is_on("stack_on"))

    def action_simulator(self) -> None:
        """Let the simulator's statuses end, or begin again."""
        self.process.send("simulator", on=not self._is_on("simulator_on"))

    def action_lamps(self) -> None:
        """Have the driving stack ask for the next of: left, right, hazard, off."""
        self.lamps_asked = (self.lamps_asked + 1) % len(_LAMPS)
        self.process.send("lamps", which=_LAMPS[self.lamps_asked])

    def action_restart(self) -> None:
        """Put the car back to where it began, at rest."""
        self.process.send("restart")

    def _is_on(self, name: str) -> bool:
        return self.model is None or bool(self.model.vehicle.get(name, True))
