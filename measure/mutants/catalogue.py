"""All mutants there are."""

from __future__ import annotations

from measure.mutants.client_hand import CLIENT_MUTANTS
from measure.mutants.motion_hand import MOTION_MUTANTS
from measure.mutants.mutant import Family, Mutant
from measure.mutants.server_hand import SERVER_MUTANTS
from measure.mutants.tables import client_mutants, server_mutants


def all_mutants() -> list[Mutant]:
    """Return every mutant, family by family."""
    return [*server_mutants(), *SERVER_MUTANTS, *client_mutants(), *CLIENT_MUTANTS, *MOTION_MUTANTS]


def mutants_of(families: tuple[Family, ...] = (), ids: tuple[str, ...] = ()) -> list[Mutant]:
    """Return the mutants of these families and with these ids; empty means all.

    Raises:
        KeyError: no mutant has one of the ids.
    """
    chosen = [mutant for mutant in all_mutants() if not families or mutant.family in families]
    if not ids:
        return chosen
    by_id = {mutant.id: mutant for mutant in chosen}
    return [by_id[id_] for id_ in ids]
