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


def first_of_each(defects, *attributes):
    """Return them as parameters; the gate has the first of those that have the same test, owner, or both."""
    seen = set()
    found = []
    for defect in defects:
        place = tuple(getattr(defect, attribute) for attribute in attributes)
        marks = pytest.mark.exhaustive("another defect in a place of which the gate has one") if place in seen else ()
        found.append(pytest.param(defect, id=str(defect), marks=marks))
        seen.add(place)
    return found


def finds_it(run):
    """Say whether a self-test that has been run has failed, or has not come to its end."""
    _passed, failed = run.checks
    ended = run.machine.ended
    return bool(failed) or ended is None or ended.kind != "exit"
