"""On the way to a suite of a user's own nothing else is looked at, and each case is found as it would be."""

from __future__ import annotations

import pytest

from hilbench.check import CheckOptions
from hilbench.check.runner import run_cases
from tests.hilbench.check.conftest import PRELUDE


def suite(clause):
    return f'{PRELUDE}@my("{clause}")\ndef test_{clause}(): pass\n'


class Looking:
    """Notes what pytest asks about before it looks at it."""

    def __init__(self):
        self.asked = []

    def pytest_ignore_collect(self, collection_path):
        self.asked.append(collection_path)

    @pytest.hookimpl(tryfirst=True)
    def pytest_collect_file(self, file_path):
        self.asked.append(file_path)


@pytest.fixture
def there(tmp_path, provider):
    """Write files, and say which cases suites have, and what was looked at."""

    def look(files, *suites):
        for name, text in files.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        looking = Looking()
        options = CheckOptions(suites=tuple(str(tmp_path / suite) for suite in suites))
        planned = run_cases(options, provider, more=[looking]).planned
        looked_at = {path.relative_to(tmp_path).as_posix() for path in looking.asked if path.name != "__pycache__"}
        return [one.id for one in planned], looked_at

    return look


def test_what_lies_beside_it_and_above_it_is_not_looked_at(there):
    files = {"a/test_lamp.py": suite("A1"), "a/other.py": "", "b/test_more.py": "", "test_c.py": "1 / 0"}
    assert there(files, "a/test_lamp.py") == (["lamp/A1"], {"a/test_lamp.py"})


def test_two_in_two_folders_keep_their_order(there):
    files = {"b/c/test_one.py": suite("B1"), "b/test_two.py": suite("B2"), "b/d/test_three.py": "1 / 0"}
    found = ["two/B2", "one/B1"], {"b/test_two.py", "b/c/test_one.py"}
    assert there(files, "b/test_two.py", "b/c/test_one.py") == found


def test_all_of_a_folder_are_found_and_one_of_them_that_is_named_again_once(there):
    files = {"a/test_one.py": suite("A1"), "a/in/test_two.py": suite("A2"), "test_none.py": "1 / 0"}
    for suites in (["a"], ["a", "a/in/test_two.py"], ["a/in/test_two.py", "a"]):
        cases, looked_at = there(files, *suites)
        assert sorted(set(cases)) == ["one/A1", "two/A2"], suites
        assert looked_at == {"a/test_one.py", "a/in", "a/in/test_two.py"}, suites


def test_one_in_a_package_is_found(there):
    cases, looked_at = there(
        {"p/__init__.py": "", "p/test_lamp.py": suite("A1"), "test_c.py": "1 / 0"}, "p/test_lamp.py"
    )
    assert cases == ["lamp/A1"]
    assert looked_at == {"p/__init__.py", "p/test_lamp.py"}
