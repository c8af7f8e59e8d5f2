"""The lines of the entries of a list in TOML text."""

from __future__ import annotations

import tomllib

from hilbench.strict.toml_lines import find_line
from tests.each import each

LISTS = """\
few = ["a", "b"]
many = [
  "a", "b",  # two, ["x"],
  "c # no remark, ]",

  '''d
  , e''',
  [1, 2,
   3],
  { key = [
    4, 5,
    6 ], other = 7 }
]
[[table]]
list = [ # 1, 2
  1_000
  , -2.5,
]
"after" = 1
"""


@each(
    ("path", "line"),
    [
        (("few", 0), 1),
        (("few", 1), 1),
        (("few", 2), 1),  # there is none: where the list is
        (("many",), 2),
        (("many", 0), 3),
        (("many", 1), 3),
        (("many", 2), 4),
        (("many", 3), 6),
        (("many", 4), 8),
        (("many", 4, 0), 8),
        (("many", 4, 2), 9),
        (("many", 5), 10),
        (("many", 5, "key", 2), 10),  # what is in a table in one place is not told apart
        (("many", 6), 2),
        (("table", 0, "list"), 15),
        (("table", 0, "list", 0), 16),
        (("table", 0, "list", 1), 17),
        (("table", 0, "after"), 19),
    ],
)
def test_an_entry_of_a_list_has_its_own_line(path, line):
    tomllib.loads(LISTS)
    assert find_line(LISTS, path) == line
