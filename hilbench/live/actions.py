"""What can be done to a live bench, each by its name; everything that is done is an event of the journal."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from hilbench.bench import Bench
from hilbench.clock import NS_PER_S
from hilbench.driving.control import Request, RequestError
from hilbench.driving.driver import Drives
from hilbench.driving.rig import Rig
from hilbench.errors import HilbenchError
from hilbench.links.faults import Direction, Fault, FaultKind

__all__ = ["MOST_SPEED", "Actions"]

MOST_SPEED = 16.0
_LEAST_SPEED = 1 / 16
_LONGEST_MARK = 200
_MOST_SENT = 4096
"""Bytes that are sent by hand at once: more than any frame here (choice)."""
_FAULT_DETAILS = ("probability", "byte", "count", "bit", "duration_s", "baud")


class Actions:
    """See the module.

    Args:
        bench: whose journal is written.
        rig: what stands on the bench.
        driver: who drives; None where nothing can be driven.

    Attributes:
        paused: whether bench time is to stand still.
        step_ns: how far it is to go all the same, in ns.
        speed: how fast it is to pass, as a multiple of the host's.
        stopped: whether the bench is to end.
    """

    def __init__(self, bench: Bench, rig: Rig, driver: Drives | None) -> None:
        self.paused = False
        self.step_ns = 0
        self.speed = 1.0
        self.stopped = False
        self._bench = bench
        self._rig = rig
        self._driver = driver
        self._armed: list[dict[str, Any]] = []
        self._all: Mapping[str, Callable[[Request], None]] = {
            "pause": lambda _: self._pause(paused=True),
            "resume": lambda _: self._pause(paused=False),
            "step": self._step,
            "speed": self._set_speed,
            "mark": self._mark,
            "quit": self._quit,
            "hello": lambda _: None,
            **self._of_driver(),
            **self._of_line(),
            **({"reset": self._reset} if rig.reset is not None else {}),
            **({"stimulate": self._stimulate} if rig.stimulate is not None else {}),
        }

    @property
    def names(self) -> tuple[str, ...]:
        """What this bench can do."""
        return tuple(self._all)

    def obey(self, request: Request) -> None:
        """Do what is asked for; the journal has what was asked, and then why it was refused if it was.

        Raises:
            RequestError: this bench cannot, or a value is out of range.
        """
        name = request.get("do")
        action = self._all.get(str(name))
        if action is None:
            raise RequestError(f"this bench has no '{name}'")
        if name not in {"drive", "hello"}:  # who drives, and how, the driver tells when it changes
            about = {key: value for key, value in request.items() if key not in {"id", "do"}}
            self._bench.record("action", "user", do=name, **{"with": about} if about else {})
        try:
            action(request)
        except (RequestError, HilbenchError, ValueError, TypeError, KeyError) as error:
            self._bench.record("refused", "user", do=name, cause=str(error))
            raise

    def standing(self) -> Mapping[str, object]:
        """Return what was reported once and still stands; see `hilbench.bench.state_reporter.StateReporter`."""
        struck = sum((tap.struck for tap in self._rig.taps.values()), Counter[tuple[str, str]]())
        return {
            "paused": self.paused,
            "speed": self.speed,
            "driver": None if self._driver is None else self._driver.who,
            "armed": list(self._armed),
            "struck": [[fault, towards, count] for (fault, towards), count in struck.items()],
            "outages": {line: tap.outages for line, tap in self._rig.taps.items()},
        }

    # --- who drives

    def _of_driver(self) -> dict[str, Callable[[Request], None]]:
        driver = self._driver
        if driver is None:
            return {}
        return {
            **({"drive": self._drive} if driver.by_hand else {}),
            "stop": lambda _: driver.stop(),
            **({"demo": lambda _: driver.begin_demo()} if self._rig.demo else {}),
            **driver.commands,
        }

    def _drive(self, request: Request) -> None:
        assert self._driver is not None
        forward, turn = _number(request, "forward", -1, 1), _number(request, "turn", -1, 1)
        self._driver.take(forward, turn, pad=request.get("pad") is True)

    # --- the line

    def _of_line(self) -> dict[str, Callable[[Request], None]]:
        if not self._rig.taps:
            return {}
        return {"send": self._send, "inject": self._inject, "clear-faults": lambda _: self._clear()}

    def _line(self, request: Request) -> str:
        """Return which line is meant; the first if none is named."""
        taps = self._rig.taps
        line = str(request.get("line") or next(iter(taps)))
        if line not in taps:
            raise RequestError(f"no line '{line}': {', '.join(taps)}")
        return line

    def _send(self, request: Request) -> None:
        try:
            data = bytes.fromhex(str(request.get("data", "")))
        except ValueError:
            raise RequestError("data is bytes in hex") from None
        if not 1 <= len(data) <= _MOST_SENT:
            raise RequestError(f"data has 1 to {_MOST_SENT} bytes")
        self._rig.taps[self._line(request)].send(data)

    def _inject(self, request: Request) -> None:
        taps, line = self._rig.taps, self._line(request)
        try:
            kind = FaultKind(request.get("kind"))
        except ValueError:
            raise RequestError(
                f"no fault '{request.get('kind')}': {', '.join(one.value for one in FaultKind)}"
            ) from None
        given: dict[str, Any] = {key: request[key] for key in _FAULT_DETAILS if key in request}
        if not {"probability", "byte"} & given.keys():
            given["at_s"] = 0.0
        direction = Direction.A_TO_B if request.get("towards", "target") == "target" else Direction.B_TO_A
        taps[line].inject(Fault(kind=kind, direction=direction, **given))
        if "probability" in given:  # the others strike once; these until they are taken back
            about = {"fault": kind.value, "towards": taps[line].towards(direction), "probability": given["probability"]}
            self._armed.append({"source": line, **about})
            self._bench.record("armed", line, **about)

    def _clear(self) -> None:
        self._bench.record("disarmed", "line")
        self._armed.clear()
        for tap in self._rig.taps.values():
            tap.clear()

    # --- time

    def _pause(self, *, paused: bool) -> None:
        self.paused = paused

    def _step(self, request: Request) -> None:
        seconds = _number(request, "seconds", 1e-6, 10)
        self.paused = True
        self.step_ns += round(seconds * NS_PER_S)

    def _set_speed(self, request: Request) -> None:
        self.speed = _number(request, "factor", _LEAST_SPEED, MOST_SPEED)

    # --- the rest

    def _mark(self, request: Request) -> None:
        if len(str(request.get("text", ""))) > _LONGEST_MARK:
            raise RequestError(f"a mark has at most {_LONGEST_MARK} characters")

    def _reset(self, _request: Request) -> None:
        assert self._rig.reset is not None
        self._rig.reset()

    def _stimulate(self, request: Request) -> None:
        assert self._rig.stimulate is not None
        self._rig.stimulate(str(request.get("text", "")))

    def _quit(self, _request: Request) -> None:
        self.stopped = True


def _number(request: Request, name: str, least: float, most: float) -> float:
    value = request.get(name)
    if not isinstance(value, int | float) or not math.isfinite(value) or not least <= value <= most:
        raise RequestError(f"{name} is a number from {least:g} to {most:g}")
    return float(value)
