"""Sequences of accesses as drivers make them, against the second opinion: see sequences.txt."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.share import few

CLOCKS = (("AHBENR", 0x55), ("APB2ENR", 0x5E7D), ("APB1ENR", 0x1AE6_4807))


def read_sequences():
    """Return the lines of each sequence, by its name."""
    sequences, lines = {}, []
    for line in (Path(__file__).parent / "sequences.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("== "):
            lines = sequences[line[3:]] = []
        elif line and not line.startswith("#"):
            lines.append(line)
    return sequences


SEQUENCES = read_sequences()


def parse(name, lines):
    """Return the operations of a sequence, and what comes in on the line."""
    operations, incoming = [("write4", f"RCC_{register}", bits) for register, bits in CLOCKS], b""
    for line in lines:
        access, _, label = (part.strip() for part in line.partition("|"))
        does, *rest = access.split()
        if does == "line":
            incoming = bytes.fromhex("".join(rest))
            continue
        where, value = rest[0], int(rest[1], 16) if len(rest) > 1 else 0
        place = where if "_" in where else int(where, 16)
        operations.append((does, place, value, (name, label) if label else None))
    return operations, incoming


@pytest.mark.parametrize("name", few([*SEQUENCES], 10, "the gate has ten of the sequences"))
def test_sequence(bench, table, compare, make_program, name):
    complaints, taken = compare(make_program(bench, *parse(name, SEQUENCES[name])))
    ours, theirs = (int("".join(f"{exception:02X}" for _, exception in side) or "0", 16) for side in taken)
    complaints += table.complaints(name, "exceptions taken", ours, theirs)
    assert not complaints, "\n".join(["", *complaints])


def test_every_line_of_the_table_is_about_something(table):
    named = {operation[3] for name in SEQUENCES for operation in parse(name, SEQUENCES[name])[0] if len(operation) > 3}
    labels = {*(label for label in named if label), *((name, "exceptions taken") for name in SEQUENCES)}
    of_sequences = [row for row in table.rows if ":" in row.where or "_" not in row.where]
    assert not [row for row in of_sequences if not any(row.covers(*label) for label in labels)]
