"""A defect of the model, and whether a self-test finds it."""

from __future__ import annotations

from dataclasses import dataclass


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


def finds_it(run):
    """Say whether a self-test that has been run has failed, or has not come to its end."""
    _passed, failed = run.checks
    ended = run.machine.ended
    return bool(failed) or ended is None or ended.kind != "exit"
