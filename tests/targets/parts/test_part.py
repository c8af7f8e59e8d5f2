"""The seam: every kind of part keeps what it promises to the bench."""

from __future__ import annotations

import dataclasses

import pytest

from targets.parts import PARTS, Control, Part, Ports, part_class
from targets.parts.part import check_controls
from targets.parts.settings import check_settings, describe, setting
from targets.parts.testing import Wire
from tests.each import each

KINDS = tuple(PARTS)


@each("kind", KINDS)
def test_a_kind_is_a_part_with_names_of_its_own(kind: str) -> None:
    found = part_class(kind)
    assert issubclass(found, Part)
    ends = [*found.SERIAL, *found.BUSES, *found.SPI_BUSES]
    names = [item.name for item in (*found.TERMINALS, *found.QUANTITIES, *found.CONTROLS)] + ends
    assert len(names) == len(set(names))
    assert all(names)


@each("kind", KINDS)
def test_every_setting_has_a_unit_and_a_source(kind: str) -> None:
    settings = part_class(kind).Settings()
    assert dataclasses.fields(settings)
    for item in describe(settings):
        assert item.source
        assert isinstance(item.unit, str)
        assert item.unit or isinstance(item.value, str | bool), f"{item.name} is a number without a unit"
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(settings, dataclasses.fields(settings)[0].name, 0)


@each("kind", [kind for kind in KINDS if part_class(kind).BUSES])
def test_a_part_answers_on_its_bus_at_the_address_that_it_says(kind: str) -> None:
    found = part_class(kind)
    field = next(field for field in dataclasses.fields(found.Settings) if field.name == found.ADDRESSED_BY)
    for value in (field.default, True if field.default is False else 7):
        settings = found.Settings(**{field.name: value})
        part = found(settings, Ports(), seed=0)
        part.power_on(0)
        slave = part.slave(found.BUSES[0])
        there = [address for address in range(128) if slave.address(address, False, 1_000_000_000)]
        assert there == [found.address_of(settings)]


@each("kind", KINDS)
def test_a_part_lives_without_any_connection(kind: str) -> None:
    found = part_class(kind)
    part = found(found.Settings(), Ports(), seed=0)
    part.power_on(0)
    for step in range(1000):
        from_ns, to_ns = step * 4_000_000, (step + 1) * 4_000_000
        part.advance(from_ns)
        part.before_step(from_ns, to_ns)
        part.after_step(from_ns, to_ns, {}, {})
        part.receive(b"\xfa\xfb\x06", from_ns)
        deadline_ns = part.next_deadline_ns()
        assert deadline_ns is None or deadline_ns > from_ns


@each("kind", KINDS)
def test_slaves_are_those_that_are_named(kind: str) -> None:
    found = part_class(kind)
    part = found(found.Settings(), Ports(), seed=0)
    for name in found.BUSES:
        part.slave(name).end(0)
    for name in found.SPI_BUSES:
        assert part.spi_slave(name).modes <= {0, 1, 2, 3}
    for slave in (part.slave, part.spi_slave):
        with pytest.raises(KeyError):
            slave("no such end")


@each("kind", KINDS)
def test_quantities_that_go_out_are_those_that_are_named(kind: str) -> None:
    found = part_class(kind)
    part = found(found.Settings(), Ports(), seed=0)
    part.power_on(0)
    out = {quantity.name for quantity in found.QUANTITIES if quantity.direction.value == "out"}
    assert set(part.before_step(0, 1)) == out


@each("kind", KINDS)
def test_an_unknown_control_is_refused(kind: str) -> None:
    found = part_class(kind)
    part = found(found.Settings(), Ports(), seed=0)
    part.power_on(0)
    with pytest.raises(ValueError, match="no control 'lever'"):
        part.set({"lever": 1.0}, 0)


def test_unknown_kinds_have_no_class() -> None:
    with pytest.raises(KeyError):
        part_class("flux-capacitor")


def test_controls_are_held_to_their_range() -> None:
    controls = (Control(name="stick", least=-1, greatest=1),)
    check_controls(controls, {"stick": -1.0})
    for value in (1.1, float("nan")):
        with pytest.raises(ValueError, match="stick goes from -1 to 1"):
            check_controls(controls, {"stick": value})


def test_what_is_not_connected_reads_low_and_goes_nowhere() -> None:
    ports = Ports()
    wire = ports.input("x")
    assert (wire.level(), wire.level_at(5), wire.mean(0, 9), wire.latch()) == (False, False, 0.0, False)
    ports.output("x").set(True, 3)
    ports.serial(b"abc")
    ports.tell(object())


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class _Sample:
    count: int = setting(1, "pieces", "choice", least=0, greatest=9)
    size_m: float = setting(1.0, "m", "choice", least=0.0)
    rest_s: float | None = setting(None, "s", "choice", least=0.5)
    fast: bool = setting(False, "", "choice")

    def __post_init__(self) -> None:
        check_settings(self)


@each(
    ("name", "value", "complaint"),
    [
        ("count", 10, "count must be at most 9"),
        ("count", -1, "count must be at least 0"),
        ("count", 1.5, "count must be int"),
        ("count", True, "count must be int"),
        ("size_m", float("inf"), "size_m must be finite"),
        ("size_m", float("nan"), "size_m must be finite"),
        ("size_m", "big", "size_m must be float"),
        ("rest_s", 0.1, "rest_s must be at least 0.5"),
        ("rest_s", "no", "rest_s must be float or nothing"),
        ("fast", 1, "fast must be bool"),
    ],
)
def test_settings_name_what_is_wrong(name: str, value: object, complaint: str) -> None:
    with pytest.raises(ValueError, match=rf"^{complaint}"):
        _Sample(**{name: value})


def test_whole_numbers_will_do_for_fractions() -> None:
    assert _Sample(size_m=2, rest_s=1).size_m == 2


def test_a_wire_knows_levels_and_means() -> None:
    wire = Wire()
    wire.set(True, 10)
    wire.set(None, 30)
    assert [wire.level_at(ns) for ns in (9, 10, 29, 30)] == [False, True, True, False]
    assert wire.mean(0, 40) == 0.5
    assert wire.mean(10, 10) == 1.0
