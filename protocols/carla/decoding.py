"""The frames of the simulator's line: statuses and commands are told apart by their first letter."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from protocols import carla
from protocols.common.decoding import Decoder, NoOptions, Speaker, fields_of
from protocols.common.items import Item, Kind
from protocols.common.layout import Body, Region, laid_out

__all__ = ["decoder", "encode", "regions"]

_NO_FIELD = frozenset({"structure", "unused", "unread"})


def decoder(options: NoOptions, speaker: Speaker) -> Decoder:
    """Return a decoder; frames of both ends may be mixed."""
    del options, speaker
    return _CarlaDecoder()


def encode(message: carla.StatusFrame | carla.CommandFrame, options: NoOptions) -> bytes:
    """Return the bytes of a status or of a command.

    Raises:
        LocalProtocolError: a value does not fit its field.
    """
    del options
    return carla.encode_status(message) if isinstance(message, carla.StatusFrame) else carla.encode_command(message)


def regions(raw: bytes, options: NoOptions, *, sent: bool) -> list[Region]:
    """Return letters and values of a sound frame; a value is called what it means in the mode of its frame."""
    del options, sent
    is_status = len(raw) <= carla.STATUS_BYTES
    layout = carla.STATUS_LAYOUT if is_status else carla.COMMAND_LAYOUT
    whole = Body(raw, carla.decode_status if is_status else _command_of, carla.RemoteProtocolError)
    parts, at = [("start", 1)], 1
    for field in layout.fields:
        name = whole.name_of(at + 1) if field.size > 1 else field.name
        parts += [(f"letter {chr(field.tag)}", 1), (field.name if name in _NO_FIELD else name, field.size)]
        at += 1 + field.size
    parts.append(("end", 1))
    padding = len(raw) - at - 1
    return laid_out(raw, [*parts, ("NUL", padding)] if padding > 0 else parts)


def _command_of(raw: bytes) -> Any:
    frame = carla.decode_command(raw)
    return carla.command_in(frame) or frame


class _CarlaDecoder:
    """Either end of the simulator's line. What a command's fields mean, and are called here, hangs on its mode.

    A command is known when the byte behind it is known: the NUL that ends it belongs to it.
    """

    def __init__(self) -> None:
        self._reader = carla.StreamReader((carla.STATUS_LAYOUT, carla.COMMAND_LAYOUT), _believe)
        self._untold = bytearray()
        self._command: Item | None = None

    def feed(self, data: bytes) -> list[Item]:
        """See `Decoder`."""
        self._untold += data
        return self._tell(self._reader.receive(data, 0))

    def find(self, data: bytes) -> list[Item]:
        """See `Decoder`: what a frame says is known with its end."""
        return self.feed(data)

    def sort(self, found: Item) -> str | None:
        """See `Decoder`."""
        return found.name if found.kind is Kind.FRAME else None

    def read(self, found: Item) -> Item:
        """See `Decoder`."""
        return found

    def finish(self) -> list[Item]:
        """See `Decoder`."""
        items = self._tell(self._reader.reset())
        last, self._command = self._command, None
        return items if last is None else [*items, last]

    def _tell(self, found: list[carla.Found]) -> list[Item]:
        items: list[Item] = []
        for one in found:
            items += self._command_items()
            if isinstance(one, carla.CommandFrame):
                self._command = _command(one, self._take(carla.COMMAND_LAYOUT.length))
            elif isinstance(one, carla.StatusFrame):
                items.append(_frame("Status", one, one, self._take(carla.STATUS_LAYOUT.length)))
            else:
                items.append(Item(kind=Kind.DROPPED, name=one.reason.value, raw=self._take(len(one.data))))
        return items + self._command_items()

    def _command_items(self) -> list[Item]:
        """The command before, if the byte behind it has come, and is its NUL or not."""
        command = self._command
        if command is None or not self._untold:
            return []
        self._command = None
        padding = carla.COMMAND_LAYOUT.padding
        behind = self._take(len(padding)) if self._untold.startswith(padding) else b""
        return [replace(command, raw=command.raw + behind)]

    def _take(self, count: int) -> bytes:
        """The bytes themselves: a NaN would not survive being encoded again."""
        taken = bytes(self._untold[:count])
        del self._untold[:count]
        return taken


def _believe(frame: carla.StatusFrame | carla.CommandFrame) -> None:
    """Every frame whose letters are right is shown, whatever it says."""
    del frame


def _command(frame: carla.CommandFrame, raw: bytes) -> Item:
    said = carla.command_in(frame)
    if said is None:
        return Item(kind=Kind.UNREADABLE, name=f"mode {frame.mode}, which nobody knows", raw=raw)
    return _frame(carla.Mode(frame.mode).name, frame, said, raw)


def _frame(
    name: str,
    frame: carla.StatusFrame | carla.CommandFrame,
    said: carla.StatusFrame | carla.AckermannCommand | carla.ManualCommand,
    raw: bytes,
) -> Item:
    return Item(kind=Kind.FRAME, name=name, raw=raw, fields=fields_of(said), message=frame)
