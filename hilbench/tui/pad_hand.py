"""A hand at a game pad: while the dead man's button is held the bench is driven, as by keys; let go, it is stopped."""

from __future__ import annotations

from hilbench.tui.bench_process import BenchProcess
from hilbench.tui.pads import Pads
from hilbench.tui.recorded import RecordedBench

__all__ = ["PadHand"]


class PadHand:
    """See the module.

    Args:
        pads: the pads at this machine; None for none.

    Attributes:
        text: what the pad does, in a few words; empty while there is none.
    """

    def __init__(self, pads: Pads | None) -> None:
        self.text = ""
        self._pads = pads
        self._drives = False

    def look(self, process: BenchProcess | RecordedBench, now_s: float) -> list[str]:
        """Take what the pad has reported and ask the bench for it; return what there is to be said of the pad.

        Args:
            process: the bench.
            now_s: any time in seconds that only grows.
        """
        if self._pads is None:
            return []
        said = self._pads.poll(now_s)
        state = self._pads.state
        forward, turn = state.shares
        if state.held and "drive" in process.actions:
            self._drives = True
            process.send("drive", forward=round(forward, 3), turn=round(turn, 3), pad=True)
        elif self._drives:
            self._drives = False
            process.send("stop")
        for asked in state.asked:
            if asked in process.actions:
                process.send(asked)
        state.asked.clear()
        how = "drives" if self._drives else "hold L1"
        self.text = f"pad {forward:+.2f} ahead {turn:+.2f} left, {how}" if self._pads.name else ""
        return said

    def close(self) -> None:
        """Let go of the pad."""
        if self._pads is not None:
            self._pads.close()
