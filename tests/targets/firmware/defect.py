"""A defect of the model, and whether a self-test finds it."""

from __future__ import annotations

import inspect
import textwrap
from dataclasses import dataclass

import pytest


@dataclass(frozen=True)
class Defect:
    """What is wrong, the self-test that has to find it, and the change that makes it so."""

    what: str
    test: str
    owner: type
    method: str
    right: str
    wrong: str

    def __str__(self):
        return f"{self.test}: {self.what}"

    def function(self):
        """Return what is to be replaced, and whether it is a property."""
        member = inspect.getattr_static(self.owner, self.method)
        return (member.fget, True) if isinstance(member, property) else (member, False)

    def source(self):
        """Return the text of it as it is."""
        source = textwrap.dedent(inspect.getsource(self.function()[0])).removeprefix("@property\n")
        assert self.right in source, f"{self.owner.__name__}.{self.method} has changed: describe this defect anew"
        return source


def some(defects, every):
    """Return them as parameters; the gate has the first of every so many self-tests that have to find them."""
    tests = list(dict.fromkeys(defect.test for defect in defects))
    first = {test: next(defect for defect in defects if defect.test == test) for test in tests[::every]}
    rest = pytest.mark.exhaustive("another defect or self-test; the gate has some of both, and each self-test passes")
    return [
        pytest.param(defect, id=str(defect), marks=() if first.get(defect.test) is defect else rest)
        for defect in defects
    ]


def finds_it(run):
    """Say whether a self-test that has been run has failed, or has not come to its end."""
    _passed, failed = run.checks
    ended = run.machine.ended
    return bool(failed) or ended is None or ended.kind != "exit"
