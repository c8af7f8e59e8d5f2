"""Signals between peripherals and pins, by name, and which pin carries which.

`Signals.output` and `Signals.input` are what a chip hands out as `targets.mcu.services.Services.output` and ``input``.
A signal that is routed to a pin goes there; an input that is not takes the output of the same name, inside the chip, as
``TIM2_TRGO`` does; without such an output it stays low. Signals that `Signals.only_at_pins` names never meet inside the
chip: an input that no pin carries has a level of its own then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from targets.mcu.pins import Pin, Pins
from targets.mcu.services import InputSignal, Watch, Wave

__all__ = ["PinInput", "PinOutput", "Signals"]


class PinOutput:
    """An output signal of a peripheral; see `targets.mcu.services.OutputSignal`.

    Attributes:
        name: such as ``TIM2_CH1``.
        level: as last set.
        catch_up: called when another signal begins to drive one of its pads, see `tell_late`.
        wave: what it does instead, if that is too fast for edges.
        pins: the pads it is routed to.
        peers: the inputs of the same name inside the chip, if the signal stays there.
    """

    __slots__ = (
        "_carried",
        "_refresh",
        "_watch",
        "catch_up",
        "level",
        "name",
        "on_watch",
        "pass_over",
        "peers",
        "pins",
        "wave",
    )

    def __init__(self, name: str) -> None:
        self.name = name
        self.level: bool | None = None
        self.wave: Wave | None = None
        self.pins: tuple[Pin, ...] = ()
        self.peers: tuple[PinInput, ...] = ()
        self._refresh: Callable[[], None] | None = None
        self.on_watch: Callable[[], None] | None = None
        self.pass_over: Callable[[], bool] | None = None
        self.catch_up: Callable[[], None] | None = None
        self._watch = Watch.NOBODY
        self._carried = False

    @property
    def refresh(self) -> Callable[[], None] | None:
        """Brings level and record up to the present cycle; None while they always are."""
        return self._refresh

    @refresh.setter
    def refresh(self, callback: Callable[[], None] | None) -> None:
        self._refresh = callback
        for pin in self.pins:
            pin.update_laziness()

    def set(self, level: bool | None) -> None:
        """Drive the signal from the present cycle on; None releases it."""
        if level is not self.level:
            self._changed(level, None)

    def set_at(self, cycle: int, level: bool | None) -> None:
        """Drive the signal from `cycle` on, which may have passed if `watch` is not LIVE."""
        if level is not self.level:
            self._changed(level, cycle)

    def set_wave(self, wave: Wave | None) -> None:
        """Say that the signal is a wave from the present cycle on, or that its edges are told (again)."""
        self.wave = wave
        for pin in self.pins:
            pin.update_wave()

    def watch(self) -> Watch:
        """Say who looks at the signal."""
        return self._watch

    def tell_late(self, catch_up: Callable[[], None], back: InputSignal | None = None) -> bool:
        """Say whether changes may be left out until `refresh` or `catch_up` is called: it drives its pads alone.

        A wire that leads to `back` alone is no hindrance, if nobody looks there.
        """
        is_alone = all(pin.is_alone(self) for pin in self.pins if pin.alternate)
        if is_alone and self._watch is not Watch.NOBODY:
            is_alone = isinstance(back, PinInput) and self._leads_to(back)
        self.catch_up = catch_up if is_alone else None
        return is_alone

    def _leads_to(self, back: PinInput) -> bool:
        """Have `refresh` called before somebody looks at the pad of `back`, if only that is wired to the pad here."""
        if len(self.pins) != 1 or back.pin is None or self._refresh is None:
            return False
        return self.pins[0].leads_to(back.pin, self._refresh)

    def at_pin(self) -> bool:
        """Say whether a pin is configured to carry the signal."""
        for pin in self.pins:  # noqa: SIM110 - every frame of every USART asks: a generator takes longer than the rest
            if pin.alternate:
                return True
        return False

    def open_drain(self) -> bool:
        """Say whether those pins only pull low."""
        return bool(self.pins) and all(pin.open_drain for pin in self.pins)

    def update_watch(self) -> None:
        """Find out anew who looks at the signal, and tell the peripheral."""
        if self.pins:
            watch = max(pin.watch() if pin.alternate else Watch.NOBODY for pin in self.pins)
        else:
            watch = Watch.LIVE if any(peer.on_change is not None for peer in self.peers) else Watch.NOBODY
        carried = self.at_pin()
        if watch is not self._watch or carried is not self._carried:
            if self._refresh is not None:
                self._refresh()
            self._watch, self._carried = watch, carried
            if self.on_watch is not None:
                self.on_watch()

    def _changed(self, level: bool | None, cycle: int | None) -> None:
        was_high = self.level is True
        self.level = level
        if self.pins:
            for pin in self.pins:
                if pin.alternate:
                    pin.update(cycle)
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
        on_reach: called after a change of what `at_pin` returns.
    """

    __slots__ = ("_on_change", "idle", "name", "on_reach", "peer", "pin")

    def __init__(self, name: str) -> None:
        self.name = name
        self.pin: Pin | None = None
        self.peer: PinOutput | None = None
        self.idle = False
        self.on_reach: Callable[[], None] | None = None
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

    def holds(self, forget: Callable[[], None]) -> bool:
        """Say whether the level stays as it is, until `forget` is called, or `on_reach`; False: nobody knows."""
        return self.peer is None if self.pin is None else self.pin.holds(forget)

    def floats_as_idle(self) -> bool:
        """Say whether the signal idles high and its pad floats: a line whose far end sends frames drives no pad."""
        return self.idle and self.pin is not None and self.pin.level is None

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
        self._routes: dict[str, tuple[str, ...]] = {}
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
        self.route_all(name, () if pin is None else (pin,))

    def route_all(self, name: str, pins: Sequence[str]) -> None:
        """Let all these pads carry the signal; who listens to it hears the last of them."""
        old = self._routes.get(name, ())
        if old == tuple(pins):
            return
        before = [(listener, listener.level()) for listener in self._inputs.get(name, ())]
        self._routes[name] = tuple(pins)
        self._connect(name)
        for pin in old:
            if pin not in pins:
                self._attach(pin)
        for listener, level in before:
            if listener.on_change is not None and listener.level() is not level and not listener.floats_as_idle():
                listener.on_change(not level)

    def route_of(self, name: str) -> str | None:
        """Return the pin that carries the signal; the last of several."""
        return next(reversed(self._routes.get(name, ())), None)

    def _connect(self, name: str) -> None:
        route = self._routes.get(name, ())
        pins = tuple(self._pins[pin] for pin in route)
        output, listeners = self._outputs.get(name), self._inputs.get(name, [])
        inside = not pins and name not in self._idle
        if output is not None:
            output.pins, output.peers = pins, tuple(listeners) if inside else ()
        for listener in listeners:
            listener.pin, listener.peer = pins[-1] if pins else None, output if inside else None
            listener.idle = self._idle.get(name, False)
            if listener.on_reach is not None:
                listener.on_reach()
        for pin in route:
            self._attach(pin)
        if not route and output is not None:
            output.update_watch()

    def _attach(self, pin: str) -> None:
        names = sorted(name for name, pins in self._routes.items() if pin in pins)
        self._pins[pin].attach(
            [self._outputs[name] for name in names if name in self._outputs],
            [listener for name in names if self._routes[name][-1] == pin for listener in self._inputs.get(name, ())],
        )
