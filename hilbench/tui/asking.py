"""What a dashboard asks of a bench: each action is a key, a command of the palette, and an event of the journal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from textual import actions, events
from textual.binding import BindingsMap, NoBinding

from hilbench.plugins.dashboard import Key
from hilbench.tui.bench_process import BenchProcess, Phase
from hilbench.tui.dialogs import InjectScreen, WordScreen
from hilbench.tui.keys import NEEDS, OF_RECORDINGS
from hilbench.tui.model.replay import Replay
from hilbench.tui.model.stick import Stick
from hilbench.tui.recorded import RecordedBench
from hilbench.tui.watching import Watching

__all__ = ["Asking"]

_SAID_FOR_S = 5.0
"""How long what was said is not said again, about as long as it stands on the screen (choice)."""
_FASTEST = 16.0
"""As of `hilbench.live.actions.MOST_SPEED`: a bench that cannot is as fast as it can."""


class Asking(Watching):
    """See the module.

    Args:
        process: the bench, or a recording, which is asked for nothing.
        replay: see `Watching`.
    """

    def __init__(self, process: BenchProcess | RecordedBench, replay: Replay | None) -> None:
        super().__init__(process, replay)
        self._stick = Stick()
        self._said_why = ("", -_SAID_FOR_S)
        self._keys: Sequence[Key] = ()
        self._asked: Counter[int] = Counter()
        self._usual = self._bindings

    def open(self, process: BenchProcess | RecordedBench, replay: Replay | None = None) -> None:
        """See `Watching`; what a key asks for by turns begins anew."""
        super().open(process, replay)
        self._asked.clear()

    @property
    def keys(self) -> Sequence[Key]:
        """The keys that the system of the bench brings."""
        return () if self.model is None else self.model.dashboard.keys

    @property
    def suites(self) -> Sequence[str]:
        """The suites that a fresh bench of this kind can be checked against."""
        return tuple(map(str, self.process.about.get("suites", ())))

    def offer_keys(self) -> None:
        """Take these keys in the place of those of the bench before; they stand behind all others."""
        if self.keys == self._keys:
            return
        self._keys = self.keys
        self._bindings = BindingsMap.from_keys({key: [*there] for key, there in self._usual.key_to_bindings.items()})
        for number, key in enumerate(self._keys):
            self.bind(key.key, f"ask({number})", description=key.shown)
        self.refresh_bindings()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Offer only what the bench can do."""
        needed = self._needed(action, parameters)
        if action == "check" and not self.suites:
            return False
        if needed is None:
            wanted = OF_RECORDINGS.get(action)
            return wanted is None or wanted is (self.replay is not None)
        return self.process.phase is Phase.LIVE and needed in self.process.actions

    def on_key(self, event: events.Key) -> None:
        """Say why a key of ours does nothing here; once in a while, for keys are held."""
        if len(self.screen_stack) > 1 or event.key in self.screen.active_bindings:
            return
        try:
            bindings = self._bindings.get_bindings_for_key(event.key)
        except NoBinding:
            return
        why, now_s = self._why_not(bindings[0].action), self.stopwatch.elapsed_s()
        if why != self._said_why[0] or now_s - self._said_why[1] >= _SAID_FOR_S:
            self._said_why = why, now_s
            self.say(why, severity="warning")

    def _why_not(self, action: str) -> str:
        """Return why an action is not offered."""
        if self.replay is not None:
            return "a recording obeys nobody"
        needed = self._needed(*actions.parse(action)[1:])
        if needed is None:
            return "this bench has no suite" if action == "check" else "only a recording can be gone through"
        if self.process.phase is not Phase.LIVE:
            return "the bench has ended" if self.process.phase is Phase.ENDED else "the bench is not there yet"
        return f"this bench has no '{needed}'"

    def _needed(self, action: str, parameters: tuple[object, ...]) -> str | None:
        """Return what an action asks of the bench; None if it asks nothing of it."""
        return self._keys[int(str(parameters[0]))].do if action == "ask" else NEEDS.get(action)

    def action_ask(self, number: int) -> None:
        """Ask for what a key of the bench's own system means."""
        key = self._keys[number]
        self.process.send(key.do, **key.sent({} if self.model is None else self.model.seen, self._asked[number]))
        self._asked[number] += 1

    def action_drive(self, axis: int, share: float) -> None:
        """Move the stick."""
        forward, turn = self._stick.press(int(axis), float(share), self.stopwatch.elapsed_s())
        self.process.send("drive", forward=forward, turn=turn)

    def action_stop(self) -> None:
        """Stop the vehicle at once."""
        self._stick.release()
        self.process.send("stop")

    def action_demo(self) -> None:
        """Let the demo driver go on."""
        self.process.send("demo")

    def action_connect(self) -> None:
        """Connect."""
        self.process.send("connect")

    def action_disconnect(self) -> None:
        """Disconnect."""
        self.process.send("disconnect")

    def action_reset(self) -> None:
        """Press the reset button."""
        self.process.send("reset")

    def action_pause(self) -> None:
        """Let bench time stand still, or go on."""
        self.process.send("resume" if self.model is not None and self.model.paused else "pause")

    def action_step(self) -> None:
        """Go a tenth of a second further."""
        self.process.send("step", seconds=0.1)

    def action_faster(self) -> None:
        """Let bench time pass twice as fast."""
        self.process.send("speed", factor=min(_FASTEST, 2 * (self.model.speed if self.model else 1.0)))

    def action_slower(self) -> None:
        """Let bench time pass half as fast."""
        self.process.send("speed", factor=max(1 / _FASTEST, 0.5 * (self.model.speed if self.model else 1.0)))

    def action_fast(self) -> None:
        """Let bench time pass as fast as it can, up to 16 times; or as the host's again."""
        self.process.send("speed", factor=1.0 if self.model is not None and self.model.speed != 1 else _FASTEST)

    def action_clear_faults(self) -> None:
        """Take all faults back."""
        self.process.send("clear-faults")

    def action_inject(self) -> None:
        """Ask for a fault and put it on the line."""

        def put(asked: dict[str, object] | None) -> None:
            if asked:
                self.process.send("inject", **asked)

        self.push_screen(InjectScreen(list(self.model.lines) if self.model else []), put)

    def action_stimulate(self) -> None:
        """Ask for a stimulus and give it to a board."""

        def give(text: str | None) -> None:
            if text:
                self.process.send("stimulate", text=text)

        self.push_screen(WordScreen("Give a board: PC13=0/50ms, PA0=1.65V, 1s:usart1=hello, reset=press"), give)

    def action_mark(self) -> None:
        """Ask for a word and put it into the journal."""

        def mark(word: str | None) -> None:
            if word is not None:
                self.process.send("mark", text=word)

        self.push_screen(WordScreen("Mark this moment as"), mark)
