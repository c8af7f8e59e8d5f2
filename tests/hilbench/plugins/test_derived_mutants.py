"""A protocol of somebody else's gets its mutants from its record alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from measure.mutants.derived.fields import Number
from measure.mutants.derived.mutant import Fault, Mutant
from measure.mutants.derived.subjects import bench_of
from measure.mutants.derived.tape import derive, recorded, touched
from measure.mutants.derived.trial import tried
from measure.mutants.wire import Way

TANK = Path(__file__).parents[3] / "examples" / "tank"


@pytest.fixture(autouse=True)
def installed(example):
    """Install the example."""
    example(TANK)


@pytest.fixture
def subject():
    """The model of the example's bench."""
    return bench_of(str(TANK / "model.toml"), "tank", ())


def test_fields_of_a_record_without_regions_are_found_by_trying(subject):
    from tank.frames import Level, encode

    places = {place.name: place for place in subject.reading(Way.OUT).places([encode(Level(850, 30, False))])}
    assert places["level_mm"].number == Number(order="little")
    assert (places["level_mm"].start, places["level_mm"].size) == (2, 2)
    assert places["percent"].size == 1


@pytest.mark.slow("a suite is collected for each mutant")
def test_its_mutants_are_derived_and_found(subject):
    tape = recorded(subject, at_port=False)
    mutants = {mutant.id: mutant for mutant in derive(subject, tape)}
    for id_ in ("says:Level:percent:plus", "says:Level:dropped", "hears:SetValve:late", "State:WATCHDOG:twice"):
        mutant = mutants[id_]
        assert tried(subject, mutant, touched(subject, mutant, tape), at_port=False).found, id_


def test_its_mutants_are_found_at_a_port(subject):
    mutant = Mutant(fault=Fault.DROPPED, way=Way.OUT, message="Level")
    assert tried(subject, mutant, ["tank"], at_port=True).found
