"""Some bytes of one stream, and those that an event of a journal holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hilbench.plugins.discovery import PLUGINS
from protocols.common.decoding import Speaker

__all__ = ["Chunk", "chunk_of", "line_of", "speaker_of"]

_SPEAKERS: Mapping[str, Speaker] = {"device": "target", "server": "target", "checker": "host", "client": "host"}
"""Who speaks at the sources that any bench may have; a system names its own beside them."""

_OTHER = {"host": "target", "target": "host", "": ""}


@dataclass(frozen=True, slots=True, kw_only=True)
class Chunk:
    """Some bytes of one stream.

    Attributes:
        data: the bytes.
        stream: which of several; empty where there is one.
        speaker: who sends it, as far as that is known.
        ns: bench time, in ns; None where the source has no times.
    """

    data: bytes
    stream: str = ""
    speaker: Speaker = ""
    ns: int | None = None


def chunk_of(event: Any) -> Chunk | None:
    """Return the bytes of an event of a journal; None if it is about something else.

    Raises:
        ValueError, TypeError, KeyError: it is no event.
    """
    kind = event["kind"]
    if kind not in {"tx", "rx", "dropped"} or "data" not in event:
        return None
    source, line, sent = str(event["source"]), line_of(event), kind == "tx"
    speaker = speaker_of(source)
    return Chunk(
        data=bytes.fromhex(event["data"]),
        stream=f"{source}{line and '.'}{line} {'tx' if sent else 'rx'}",
        speaker=speaker if sent else _OTHER[speaker],
        ns=int(event["ns"]),
    )


def line_of(event: Any) -> str:
    """Return at which of its source's lines something came or went; empty where the source has but one."""
    return str(event.get("line", ""))


def speaker_of(source: str) -> Speaker:
    """Return who speaks at a source of a journal; what a USART of a board sends is taken for what a host sends."""
    found = _SPEAKERS.get(source) or PLUGINS.systems.speakers().get(source)
    return found or ("host" if ".usart" in source else "")
