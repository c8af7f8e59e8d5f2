"""What topics of DDS and their types are called in ROS 2: topics, and the parts of services and actions.

    rt/chatter                       /chatter
    rq/addRequest, rr/addReply       the service /add
    rt/walk/_action/feedback         the action /walk, as all of `ACTION_PARTS`
    std_msgs::msg::dds_::String_     std_msgs/msg/String

Sources: design.ros2.org, "Topic and Service name mapping to DDS" and "Actions".
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum

from protocols.xrce.descriptions import TopicDescription

__all__ = ["ACTION_PARTS", "RosKind", "RosName", "ros_name", "ros_type", "topic_of_ros"]

_ACTION = "/_action/"
ACTION_PARTS = ("send_goal", "cancel_goal", "get_result", "feedback", "status")
"""What an action is made of: three services, two topics."""
_TYPE = re.compile(r"([A-Za-z]\w{0,99})::(msg|srv|action)::dds_::([A-Za-z]\w{0,99})_", re.ASCII)
"""Of names that are fit for files; how long is a choice."""
_HALVES = {"rq/": ("Request", "request"), "rr/": ("Reply", "reply")}


class RosKind(Enum):
    """What a topic of DDS is part of."""

    TOPIC = "topic"
    SERVICE = "service"
    ACTION = "action"


@dataclass(frozen=True, slots=True)
class RosName:
    """What a topic of DDS is in ROS 2.

    Attributes:
        kind: of what.
        name: of that, as ``/chatter``.
        part: of an action, one of `ACTION_PARTS`; empty of others.
        half: of a service: ``request`` or ``reply``; empty of topics.
    """

    kind: RosKind
    name: str
    part: str = ""
    half: str = ""


def ros_name(topic: str) -> RosName | None:
    """What a topic is in ROS 2, by its name; None if its name is none of ROS 2."""
    name, half = topic[2:], ""
    if topic[:3] in _HALVES:
        ending, half = _HALVES[topic[:3]]
        if not name.endswith(ending):
            return None
        name = name.removesuffix(ending)
    elif not topic.startswith("rt/"):
        return None
    action, between, part = name.rpartition(_ACTION)
    if between and part in ACTION_PARTS and bool(half) is (part in ACTION_PARTS[:3]):
        return RosName(RosKind.ACTION, action, part, half)
    return RosName(RosKind.SERVICE if half else RosKind.TOPIC, name, "", half)


def ros_type(type_name: str) -> str | None:
    """``std_msgs/msg/String`` of ``std_msgs::msg::dds_::String_``; None of what ROS 2 names otherwise."""
    found = _TYPE.fullmatch(type_name)
    return None if found is None else "/".join(found.groups())


def topic_of_ros(name: str, message: str, *, half: str = "") -> TopicDescription:
    """The topic of DDS for a topic of ROS 2, or for half of a service.

    Args:
        name: as ``/chatter``.
        message: the full name of what is said there, as ``std_msgs/msg/String``.
        half: of a service, ``request`` or ``reply``.
    """
    prefix, ending = next(((one, end) for one, (end, which) in _HALVES.items() if which == half), ("rt/", ""))
    package, kind, short = message.split("/")
    return TopicDescription(f"{prefix[:2]}{name}{ending}", f"{package}::{kind}::dds_::{short}_")
