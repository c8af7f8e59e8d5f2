"""The settings of an agent: what makes none is refused by name, before anything is served."""

from __future__ import annotations

import math

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.errors import UsageError
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


def test_folders_of_types_are_beside_the_bench_file(tmp_path):
    text = 'version = 1\n[targets.agent]\nmodel = "xrce-agent"\n[targets.agent.settings]\ntypes = ["share"]\n'
    file = tmp_path / "my.toml"
    file.write_text(text)
    with pytest.raises(UsageError, match=f"no folder '{tmp_path / 'share'}'"):
        open_bench(str(file))
    (tmp_path / "share").mkdir()
    assert open_bench(str(file)).settings_of(AgentSettings).types == (str(tmp_path / "share"),)
