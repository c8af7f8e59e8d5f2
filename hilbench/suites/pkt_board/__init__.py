"""What a rover must do, frame by frame: every case of the PKT! catalogue, each in the profiles that hold it.

A case sends bytes and looks at the counters of the general report, at other reports, and at what somebody beside the
rover sees: LED, wheels, motor voltage. Stimuli are written as on the wire wherever the bytes are the point.
"""

from __future__ import annotations

ORDER = (
    "commands",
    "damaged",
    "behind_something",
    "parameters",
    "silence",
    "speed_control",
    "sensors",
    "sensed",
    "in_hand",
    "published",
    "newlines",
    "families",
    "sequences",
)
