"""What a dashboard writes into the working folder: its picture, the recording so far, and what is selected."""

from __future__ import annotations

from pathlib import Path

from hilbench.tui.asking import Asking
from hilbench.tui.checks_pane import ChecksPane
from hilbench.tui.dialogs import PickScreen
from hilbench.tui.frames_pane import FramesPane
from hilbench.tui.model.export import EXPORTS, Selection, exported
from hilbench.tui.panes import PlotsPane
from hilbench.tui.svg import in_cells

__all__ = ["Saving"]


class Saving(Asking):
    """See the module. It asks the panes of frames, plots and checks what is selected."""

    def action_picture(self) -> None:
        """Save the screen."""
        picture = self.export_screenshot(title=f"hilbench {self.model.name if self.model else ''}")
        self._save("svg", in_cells(picture), "the screen")

    def action_keep(self) -> None:
        """Copy the recording so far into the working folder; 'hilbench replay' opens it."""
        try:
            data = self.process.journal.read_bytes()
        except OSError as error:
            self.say(f"{self.process.journal}: {error.strerror}", severity="error")
        else:
            self._save("journal.jsonl", data.decode(errors="replace"), "the recording")

    def action_export(self) -> None:
        """Ask what is to be written to a file, and write it."""
        if self.model is None:
            self.say("nothing was recorded yet")
            return
        choices = [(f"{what} {form}", about) for what, (about, _, forms) in EXPORTS.items() for form in forms]

        def write(choice: str | None) -> None:
            if choice and self.model is not None:
                what, _, form = choice.partition(" ")
                text, count = exported(what, form, self._selection())
                self._save(f"{what}.{form}", text, f"{count} rows")

        self.push_screen(PickScreen("Export what? Into the working folder.", choices), write)

    def _selection(self) -> Selection:
        assert self.model is not None
        plots = self.query_one(PlotsPane)
        return Selection(
            model=self.model,
            frames=self.query_one(FramesPane).selected(),
            signals=plots.plotted,
            span_s=plots.span_s,
            checks=self.query_one(ChecksPane).checks_of(self.model),
        )

    def _save(self, ending: str, text: str, what: str) -> None:
        name = self.model.name.replace("/", "-") if self.model else "bench"
        at_ms = (self.model.ns if self.model else 0) // 1_000_000
        dot = "." if ending == "svg" else "-"
        path = Path.cwd() / f"hilbench-{name}-{at_ms}ms{dot}{ending}"
        try:
            path.write_text(text)
        except OSError as error:
            self.say(f"{path}: {error.strerror}", severity="error")
        else:
            self.say(f"{what} saved: {path}")
