"""Faulty vehicle interfaces: the defects of the published firmwares, one by one, and what else one gets wrong.

Also the reverse: the published firmwares without one of their defects, which the clauses that describe it must notice.
``python -m measure.mutants.vehicle`` runs the suite ``vehicle-board`` against each, writes ``docs/vehicle-defects.md``.
"""
