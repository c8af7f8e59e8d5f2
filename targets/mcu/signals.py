"""Signals between peripherals and pins, by name, and which pin carries which.

`Signals.output` and `Signals.input` are what a chip hands out as `targets.mcu.services.Services.output` and ``input``.
A signal that is routed to a pin goes there; an input that is not takes the output of the same name, inside the chip, as
``TIM2_TRGO`` does; without such an output it stays low. Signals that `Signals.only_at_pins` names never meet inside the
chip: an input that no pin carries has a level of its own then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from targets.mcu.pins import Pin, Pins
from targets.mcu.services import Watch

__all__ = ["PinInput", "PinOutput", "Signals"]


class PinOutput:
    """An output signal of a peripheral; see `targets.mcu.services.OutputSignal`.

    Attributes:
        name: such as ``TIM2_CH1``.
        level: as last set.
        pin: the pad it is routed to.
        peers: the inputs of the same name inside the chip, if the signal stays there.
    """

    __slots__ = ("_refresh", "_watch", "level", "name", "on_watch", "peers", "pin")

    def __init__(self, name: str) -> None:
        self.name = name
        self.level: bool | None = None
        self.pin: Pin | None = None
        self.peers: tuple[PinInput, ...] = ()
        self._refresh: Callable[[], None] | None = None
        self.on_watch: Callable[[], None] | None = None
        self._watch = Watch.NOBODY

    @property
    def refresh(self) -> Callable[[], None] | None:
        """Brings level and record up to the present cycle; None while they always are."""
        return self._refresh

    @refresh.setter
    def refresh(self, callback: Callable[[], None] | None) -> None:
        self._refresh = callback
        if self.pin is not None:
            self.pin.update_laziness()

    def set(self, level: bool | None) -> None:
        """Drive the signal from the present cycle on; None releases it."""
        if level is not self.level:
            self._changed(level, None)

    def set_at(self, cycle: int, level: bool | None) -> None:
        """Drive the signal from `cycle` on, which may have passed if `watch` is not LIVE."""
        if level is not self.level:
            self._changed(level, cycle)

    def watch(self) -> Watch:
        """Say who looks at the signal."""
        return self._watch

    def at_pin(self) -> bool:
        """Say whether a pin is configured to carry the signal."""
        return self.pin is not None and self.pin.alternate

    def open_drain(self) -> bool:
        """Say whether that pin only pulls low."""
        return self.pin is not None and self.pin.open_drain

    def update_watch(self) -> None:
        """Find out anew who looks at the signal, and tell the peripheral."""
        if self.pin is not None:
            watch = self.pin.watch() if self.pin.alternate else Watch.NOBODY
        else:
            watch = Watch.LIVE if any(peer.on_change is not None for peer in self.peers) else Watch.NOBODY
        if watch is not self._watch:
            if self._refresh is not None:
                self._refresh()
            self._watch = watch
            if self.on_watch is not None:
                self.on_watch()

    def _changed(self, level: bool | None, cycle: int | None) -> None:
        was_high = self.level is True
        self.level = level
        if self.pin is not None:
            if self.pin.alternate:
                self.pin.update(cycle)
        elif (level is True) is not was_high:
            for peer in self.peers:
                if peer.on_change is not None:
                    peer.on_change(level is True)


class PinInput:
    """One listener to an input signal of a peripheral; see `targets.mcu.services.InputSignal`.

    Attributes:
        name: such as ``TIM2_CH1``.
        pin: the pad it is routed to.
        peer: the output of the same name inside the chip.
        idle: the level while it has neither.
    """

    __slots__ = ("_on_change", "idle", "name", "peer", "pin")

    def __init__(self, name: str) -> None:
        self.name = name
        self.pin: Pin | None = None
        self.peer: PinOutput | None = None
        self.idle = False
        self._on_change: Callable[[bool], None] | None = None

    @property
    def on_change(self) -> Callable[[bool], None] | None:
        """Called with the new level, at the cycle of the change; None while nobody listens."""
        return self._on_change

    @on_change.setter
    def on_change(self, callback: Callable[[bool], None] | None) -> None:
        self.level()  # what has changed before is not for who listens from now on
        self._on_change = callback
        if self.pin is not None:
            self.pin.update_watch()
        elif self.peer is not None:
            self.peer.update_watch()

    def level(self) -> bool:
        """Return the present level; a floating or analog pin reads as low, and a signal of nobody as `idle`."""
        if self.pin is not None:
            return self.pin.reads_high
        if self.peer is not None:
            if self.peer.refresh is not None:
                self.peer.refresh()
            return self.peer.level is True
        return self.idle

    def at_pin(self) -> bool:
        """Say whether what is outside of a pin can reach the signal."""
        return self.pin is not None and self.pin.open_to_outside


class Signals:
    """All signals of a chip.

    Args:
        pins: the pins they may be routed to.
    """

    def __init__(self, pins: Pins) -> None:
        self._pins = pins
        self._outputs: dict[str, PinOutput] = {}
        self._inputs: dict[str, list[PinInput]] = {}
        self._routes: dict[str, str] = {}
        self._idle: dict[str, bool] = {}

    def only_at_pins(self, idle: Mapping[str, bool]) -> None:
        """Let these signals meet at pins alone, and an input that no pin carries have the level given here."""
        self._idle.update(idle)
        for name in idle:
            self._connect(name)

    def output(self, name: str) -> PinOutput:
        """Return the output signal of that name."""
        signal = self._outputs.get(name)
        if signal is None:
            signal = self._outputs[name] = PinOutput(name)
            self._connect(name)
        return signal

    def input(self, name: str) -> PinInput:
        """Return a new listener to the input signal of that name; ``TIM2_TRGO`` may have several."""
        signal = PinInput(name)
        self._inputs.setdefault(name, []).append(signal)
        self._connect(name)
        return signal

    def route(self, name: str, pin: str | None) -> None:
        """Let the pad `pin` carry the signal, or none. Who listens to it is told if its level changes by that."""
        old = self._routes.get(name)
        if old == pin:
            return
        before = [(listener, listener.level()) for listener in self._inputs.get(name, ())]
        if pin is None:
            del self._routes[name]
        else:
            self._routes[name] = pin
        self._connect(name)
        if old is not None:
            self._attach(old)
        for listener, level in before:
            if listener.on_change is not None and listener.level() is not level:
                listener.on_change(not level)

    def route_of(self, name: str) -> str | None:
        """Return the pin that carries the signal."""
        return self._routes.get(name)

    def _connect(self, name: str) -> None:
        route = self._routes.get(name)
        pin = self._pins[route] if route is not None else None
        output, listeners = self._outputs.get(name), self._inputs.get(name, [])
        inside = pin is None and name not in self._idle
        if output is not None:
            output.pin, output.peers = pin, tuple(listeners) if inside else ()
        for listener in listeners:
            listener.pin, listener.peer = pin, output if inside else None
            listener.idle = self._idle.get(name, False)
        if route is not None:
            self._attach(route)
        elif output is not None:
            output.update_watch()

    def _attach(self, pin: str) -> None:
        names = sorted(name for name, at in self._routes.items() if at == pin)
        self._pins[pin].attach(
            [self._outputs[name] for name in names if name in self._outputs],
            [listener for name in names for listener in self._inputs.get(name, ())],
        )
