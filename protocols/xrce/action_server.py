"""An action of ROS 2 that a program beside an agent serves.

    server = ActionServer(agent, "/walk", "demo/action/Walk", library)
    written = agent.receive(line, data, now_ns) + server.advance(now_ns)    # requests that have come
    for goal in server.active:                                              # what is to be done
        written += server.say(goal, {"gone_m": 0.5}, now_ns)                # feedback
        written += server.finish(goal, GoalState.SUCCEEDED, {"way_m": 1.0}, now_ns)

A goal that somebody wants to be given up is `GoalState.CANCELING` until it is finished. Sources: design.ros2.org,
"Actions"; ros2/rcl_interfaces, action_msgs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import partial
from typing import Any

from protocols.xrce.cdr import Library
from protocols.xrce.errors import RemoteProtocolError
from protocols.xrce.ros_names import topic_of_ros
from protocols.xrce.service import AgentService, Written
from protocols.xrce.space import SampleIdentity, StoredSample, Writer

__all__ = ["ActionServer", "Goal", "GoalState"]

NS_PER_S = 1_000_000_000
_FINISHED_KEPT = 16
"""Goals whose result can be asked for after their end (choice)."""
_CANCEL = "action_msgs/srv/CancelGoal"
_NO_GOAL = bytes(16)
_NONE, _UNKNOWN_GOAL, _TERMINATED = 0, 2, 3
_UNKNOWN = 0


class GoalState(IntEnum):
    """How far a goal has come (action_msgs/msg/GoalStatus)."""

    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6


_ENDED = (GoalState.SUCCEEDED, GoalState.CANCELED, GoalState.ABORTED)


@dataclass(slots=True, kw_only=True)
class Goal:
    """What somebody has asked for.

    Attributes:
        goal_id: 16 bytes.
        wanted: the goal, field by field.
        accepted_ns: when it was accepted.
        state: how far it has come.
        result: what came of it, once it has ended.
        asked: the requests for the result that wait for its end.
    """

    goal_id: bytes
    wanted: Mapping[str, Any]
    accepted_ns: int
    state: GoalState = GoalState.ACCEPTED
    result: Mapping[str, Any] = field(default_factory=dict)
    asked: list[SampleIdentity] = field(default_factory=list)


class ActionServer:
    """See the module.

    Args:
        agent: beside which it stands.
        name: of the action, as ``/walk``.
        action: its type, as ``demo/action/Walk``.
        library: has the definition of that.
        domain_id: in which it is served.
        epoch_ns: what the clock of its stamps says at time 0.
        accepts: whether it takes a goal, given its fields.

    Raises:
        LocalProtocolError: the action is not known.

    Attributes:
        goals: those that were accepted, by their ids, the oldest first; of those that have ended the latest few.
    """

    def __init__(
        self,
        agent: AgentService,
        name: str,
        action: str,
        library: Library,
        *,
        domain_id: int = 0,
        epoch_ns: int = 0,
        accepts: Callable[[Mapping[str, Any]], bool] = lambda _wanted: True,
    ) -> None:
        self._agent, self._name, self._action, self._library = agent, name, action, library
        self._domain_id, self._epoch_ns, self._accepts = domain_id, epoch_ns, accepts
        self.goals: dict[bytes, Goal] = {}
        self._came: list[tuple[str, StoredSample]] = []
        self._services = {
            "send_goal": (f"{action}_SendGoal", self._send_goal),
            "cancel_goal": (_CANCEL, self._cancel),
            "get_result": (f"{action}_GetResult", self._get_result),
        }
        library.full_text(f"{action}_FeedbackMessage")
        self._replies = {part: self._serve(part, service) for part, (service, _) in self._services.items()}
        self._feedback = self._writer("feedback", f"{action}_FeedbackMessage")
        self._status = self._writer("status", "action_msgs/msg/GoalStatusArray")

    @property
    def active(self) -> list[Goal]:
        """The goals that have not ended."""
        return [goal for goal in self.goals.values() if goal.state not in _ENDED]

    def advance(self, now_ns: int) -> Written:
        """Answers the requests that have come since the last call; one that makes no sense gets no answer."""
        written: Written = []
        while self._came:
            part, sample = self._came.pop(0)
            service, answer = self._services[part]
            try:
                said = self._library.decode(f"{service}_Request", sample.data, little_endian=sample.little_endian)
            except RemoteProtocolError:
                continue
            if sample.identity is not None:
                written += answer(said, sample.identity, now_ns)
        return written

    def say(self, goal: Goal, feedback: Mapping[str, Any], now_ns: int) -> Written:
        """Says how far a goal has come, in the fields of the action's feedback; with the first it is executed."""
        written: Written = []
        if goal.state is GoalState.ACCEPTED:
            goal.state = GoalState.EXECUTING
            written += self._tell_status(now_ns)
        message = {"goal_id": {"uuid": goal.goal_id}, "feedback": feedback}
        data = self._library.encode(f"{self._action}_FeedbackMessage", message)
        return written + self._agent.write(self._feedback, data, now_ns)

    def finish(self, goal: Goal, state: GoalState, result: Mapping[str, Any], now_ns: int) -> Written:
        """Ends a goal, and hands its result to those who have asked for it."""
        goal.state, goal.result = state, result
        written = self._tell_status(now_ns)
        asked, goal.asked = goal.asked, []
        for identity in asked:
            written += self._hand_result(goal, identity, now_ns)
        ended = [one.goal_id for one in self.goals.values() if one.state in _ENDED]
        for goal_id in ended[:-_FINISHED_KEPT]:
            del self.goals[goal_id]
        return written

    # --- requests

    def _send_goal(self, said: Mapping[str, Any], identity: SampleIdentity, now_ns: int) -> Written:
        goal_id = said["goal_id"]["uuid"]
        accepted = goal_id not in self.goals and self._accepts(said["goal"])
        stamp = self._stamp(now_ns)
        written = self._reply("send_goal", {"accepted": accepted, "stamp": stamp}, identity, now_ns)
        if accepted:
            self.goals[goal_id] = Goal(goal_id=goal_id, wanted=said["goal"], accepted_ns=now_ns)
            written += self._tell_status(now_ns)
        return written

    def _cancel(self, said: Mapping[str, Any], identity: SampleIdentity, now_ns: int) -> Written:
        """A goal by its id; those accepted up to a time; all where neither is said (action_msgs, CancelGoal.srv)."""
        goal_id, stamp = said["goal_info"]["goal_id"]["uuid"], said["goal_info"]["stamp"]
        until_ns = stamp["sec"] * NS_PER_S + stamp["nanosec"]
        everything = goal_id == _NO_GOAL and not until_ns
        given_up = [
            goal
            for goal in self.active
            if everything or goal.goal_id == goal_id or goal.accepted_ns + self._epoch_ns <= until_ns
        ]
        code = _NONE
        if not given_up and goal_id != _NO_GOAL:
            code = _TERMINATED if goal_id in self.goals else _UNKNOWN_GOAL
        for goal in given_up:
            goal.state = GoalState.CANCELING
        told = {"return_code": code, "goals_canceling": [self._info(goal) for goal in given_up]}
        return self._reply("cancel_goal", told, identity, now_ns) + self._tell_status(now_ns) * bool(given_up)

    def _get_result(self, said: Mapping[str, Any], identity: SampleIdentity, now_ns: int) -> Written:
        goal = self.goals.get(said["goal_id"]["uuid"])
        if goal is None:
            return self._reply("get_result", {"status": _UNKNOWN}, identity, now_ns)
        if goal.state in _ENDED:
            return self._hand_result(goal, identity, now_ns)
        goal.asked.append(identity)
        return []

    # --- what is said

    def _hand_result(self, goal: Goal, identity: SampleIdentity, now_ns: int) -> Written:
        return self._reply("get_result", {"status": goal.state, "result": goal.result}, identity, now_ns)

    def _reply(self, part: str, message: Mapping[str, Any], identity: SampleIdentity, now_ns: int) -> Written:
        data = self._library.encode(f"{self._services[part][0]}_Response", message)
        return self._agent.write(self._replies[part], data, now_ns, answers=identity)

    def _tell_status(self, now_ns: int) -> Written:
        told = [{"goal_info": self._info(goal), "status": goal.state} for goal in self.goals.values()]
        data = self._library.encode("action_msgs/msg/GoalStatusArray", {"status_list": told})
        return self._agent.write(self._status, data, now_ns)

    def _info(self, goal: Goal) -> dict[str, Any]:
        return {"goal_id": {"uuid": goal.goal_id}, "stamp": self._stamp(goal.accepted_ns)}

    def _stamp(self, now_ns: int) -> dict[str, int]:
        sec, nanosec = divmod(now_ns + self._epoch_ns, NS_PER_S)
        return {"sec": sec, "nanosec": nanosec}

    # --- its endpoints

    def _serve(self, part: str, service: str) -> Writer:
        topic = topic_of_ros(f"{self._name}/_action/{part}", f"{service}_Request", half="request")
        self._agent.listen(topic.name, topic.type_name, partial(self._take, part), domain_id=self._domain_id)
        return self._writer(part, f"{service}_Response", half="reply")

    def _take(self, part: str, sample: StoredSample) -> None:
        self._came.append((part, sample))

    def _writer(self, part: str, message: str, *, half: str = "") -> Writer:
        topic = topic_of_ros(f"{self._name}/_action/{part}", message, half=half)
        return self._agent.writer(topic.name, topic.type_name, domain_id=self._domain_id)
