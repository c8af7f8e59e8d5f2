"""What the messages of an MCAP file look like: JSON schemas, by kind of event, and those that Foxglove knows.

The names and fields of the latter are those of github.com/foxglove/foxglove-sdk (schemas/jsonschema).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hilbench.clock import NS_PER_S
from hilbench.recordings.layout import Event

__all__ = ["EVENT_SCHEMA", "FRAME_SCHEMA", "LOG", "POSE", "event_schema", "frame_schema", "log_of", "pose_of"]

EVENT_SCHEMA = "hilbench.event."
"""What the names of the schemas of events begin with; their kind follows."""
FRAME_SCHEMA = "hilbench.Frame"

_MICRO = 1e-6
_INFO, _WARNING, _ERROR = 2, 3, 4

_TEXT = {"type": "string"}
_WHOLE = {"type": "integer"}
_NUMBER = {"type": "number"}
_HEX = {"type": "string", "contentEncoding": "base16"}
_TIME = {"type": "object", "title": "time", "properties": {"sec": _WHOLE, "nsec": _WHOLE}}
_BYTES = {"data": _HEX, "from_ns": _WHOLE}
_OF_KIND: Mapping[str, Mapping[str, Any]] = {
    "tx": _BYTES,
    "rx": {**_BYTES, "packet": _TEXT},
    "dropped": {**_BYTES, "reason": _TEXT},
    "pin": {"level": {"type": ["boolean", "null"]}},
    "pwm": {"period_ns": _WHOLE, "high_ns": _WHOLE, "duty": _NUMBER, "edges": _WHOLE, "in_ns": _WHOLE},
    "pose": {"x_m": _WHOLE, "y_m": _WHOLE, "z_m": _WHOLE, "yaw_rad": _WHOLE},
    "event": {"name": _TEXT, "value": {"type": "object"}},
    "verdict": {"verdict": _TEXT, "cause": _TEXT},
    "fault": {"fault": _TEXT, "towards": _TEXT},
    "case": {"case": _TEXT},
    "case-end": {"case": _TEXT, "hash": _TEXT},
    "reset": {"reason": _TEXT},
    "margins": {"timer": _TEXT, "points": {"type": "array", "items": {"type": "array", "items": _WHOLE}}},
}


def event_schema(kind: str) -> dict[str, Any]:
    """Return the schema of a kind of events; they may have more fields than it names."""
    about = {"ns": _WHOLE, "kind": _TEXT, "source": _TEXT}
    return {"type": "object", "properties": {**about, **_OF_KIND.get(kind, {})}, "required": list(about)}


def frame_schema() -> dict[str, Any]:
    """Return the schema of a frame that was read in the bytes."""
    about = {"name": _TEXT, "kind": _TEXT, "fields": {"type": "object"}, "raw": _HEX, "offset": _WHOLE}
    return {"type": "object", "properties": about}


LOG = "foxglove.Log"
POSE = "foxglove.PoseInFrame"
FOXGLOVE_SCHEMAS: Mapping[str, Mapping[str, Any]] = {
    LOG: {
        "title": LOG,
        "type": "object",
        "properties": {"timestamp": _TIME, "level": _WHOLE, "message": _TEXT, "name": _TEXT, "file": _TEXT},
    },
    POSE: {
        "title": POSE,
        "type": "object",
        "properties": {
            "timestamp": _TIME,
            "frame_id": _TEXT,
            "pose": {
                "type": "object",
                "title": "foxglove.Pose",
                "properties": {
                    "position": {"type": "object", "properties": {"x": _NUMBER, "y": _NUMBER, "z": _NUMBER}},
                    "orientation": {
                        "type": "object",
                        "properties": {"x": _NUMBER, "y": _NUMBER, "z": _NUMBER, "w": _NUMBER},
                    },
                },
            },
        },
    },
}


def log_of(ns: int, event: Event) -> dict[str, Any] | None:
    """Return what Foxglove's log shows of an event; None if that is nothing."""
    kind, source = event["kind"], str(event.get("source", ""))
    if kind == "verdict":
        verdict = str(event.get("verdict", ""))
        level, text = (_INFO if verdict == "pass" else _ERROR), f"{verdict} {event.get('cause', '')}".strip()
    elif kind == "case":
        level, text = _INFO, f"case {event.get('case', '')}"
    elif kind in {"fault", "fault-refused", "break-refused", "reset", "end", "dropped", "line", "note", "stimulus"}:
        about = {name: value for name, value in event.items() if name not in {"ns", "kind", "source"}}
        level, text = _WARNING, " ".join([kind, *(f"{name}={value}" for name, value in about.items())])
    else:
        return None
    return {"timestamp": _stamp(ns), "level": level, "message": text, "name": source, "file": ""}


def pose_of(ns: int, event: Event) -> dict[str, Any] | None:
    """Return what Foxglove's 3D panel shows of an event; None if it is no pose."""
    from math import cos, sin

    if event["kind"] != "pose":
        return None
    try:
        x, y, z, yaw = (event[name] * _MICRO for name in ("x_m", "y_m", "z_m", "yaw_rad"))
    except (KeyError, TypeError):
        return None
    orientation = {"x": 0.0, "y": 0.0, "z": sin(yaw / 2), "w": cos(yaw / 2)}
    pose = {"position": {"x": x, "y": y, "z": z}, "orientation": orientation}
    return {"timestamp": _stamp(ns), "frame_id": "world", "pose": pose}


def _stamp(ns: int) -> dict[str, int]:
    seconds, rest_ns = divmod(ns, NS_PER_S)
    return {"sec": seconds, "nsec": rest_ns}
