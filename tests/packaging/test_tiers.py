"""docs/testing.md lists each test that is marked with a reason, and its reason; and to collect tests is cheap.

After a change that is meant, `HILBENCH_WRITE_TIERS=1 python -m pytest tests -k test_tiers` writes the lists anew.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import pytest

from tests.conftest import LEFT_OUT, LOADED, MARKED, WITH_A_REASON

PAGE = Path(__file__).parents[2] / "docs" / "testing.md"
WRITE = "HILBENCH_WRITE_TIERS"


def listed(config: pytest.Config, mark: str) -> list[str]:
    """Return the lines for tests with a mark: file, then function or class, number of parameter sets, and reason.

    What is left out of the gate as a whole stands there without a number.
    """
    whole = config.stash[LEFT_OUT][mark]
    outside = config.stash[MARKED][mark].items()
    of_some = {test: said for test, said in outside if not is_within(test, config.stash[LEFT_OUT]["exhaustive"])}
    lines: list[str] = []
    heading = ""
    for test in sorted({*whole, *of_some}):
        file, _, name = test.partition("::")
        if file != heading:
            heading = file
            lines += ["", f"`{file}`", ""]
        if test in whole:
            lines.append(f"- {name}: {whole[test]}")
        else:
            lines += [f"- {name} ({number}): {reason}" for reason, number in sorted(Counter(of_some[test]).items())]
    return lines


def is_within(test: str, whole: dict[str, str]) -> bool:
    return test in whole or test.rpartition("::")[0] in whole


def begin(mark: str) -> str:
    return f"<!-- {mark} -->"


def end(mark: str) -> str:
    return f"<!-- end of {mark} -->"


def section(mark: str) -> list[str]:
    """Return what the page lists for a mark."""
    text = PAGE.read_text(encoding="utf-8")
    return text.partition(begin(mark))[2].partition(end(mark))[0].splitlines()[1:]


def write(mark: str, lines: list[str]) -> None:
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(begin(mark))
    after = rest.partition(end(mark))[2]
    PAGE.write_text("\n".join([before + begin(mark), *lines, "", end(mark) + after]), encoding="utf-8")


def over_all_tests(config: pytest.Config) -> bool:
    """Say whether the run was asked for all tests; fewer may be chosen of them."""
    here = config.invocation_params.dir
    return {(here / path).resolve() for path in config.args} == {PAGE.parents[1] / "tests"}


@pytest.mark.parametrize("mark", WITH_A_REASON)
def test_each_marked_test_is_listed_with_its_reason(request, mark):
    lines = listed(request.config, mark)
    if os.environ.get(WRITE):
        assert over_all_tests(request.config), f"only a run over all tests sees each mark: {WRITE}=1 pytest tests"
        write(mark, lines)
    missing = [line for line in lines if line not in section(mark)]
    assert not missing, f"{PAGE.name} does not list, or not so: {missing}; {WRITE}=1 writes it anew"


@pytest.mark.parametrize("mark", WITH_A_REASON)
def test_nothing_is_listed_that_is_not_marked(request, mark):
    if not over_all_tests(request.config):
        pytest.skip("only a run over all tests sees each mark")
    assert section(mark) == [*listed(request.config, mark), ""]


def test_no_physics_emulator_or_dashboard_is_imported_to_collect_tests(request):
    assert request.config.stash[LOADED] == []
