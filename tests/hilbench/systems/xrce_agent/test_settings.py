"""The settings of an agent: what makes none is refused by name, before anything is served."""

from __future__ import annotations

import math

import pytest

from hilbench.systems.xrce_agent.agent import agent_of
from hilbench.systems.xrce_agent.settings import AgentSettings
from protocols.xrce.options import LONGEST_S
from tests.each import each


@each("value", [math.nan, math.inf, -math.inf, -1.0, LONGEST_S + 1])
@each("name", ["silence_s", "epoch_s"])
def test_times_that_no_clock_shows_are_refused(name, value):
    with pytest.raises(ValueError, match=f"^{name} "):
        AgentSettings(**{name: value})


def test_the_longest_times_make_an_agent():
    agent_of(AgentSettings(silence_s=LONGEST_S, epoch_s=LONGEST_S), ("line",))
    agent_of(AgentSettings(epoch_s=0), ("line",))
