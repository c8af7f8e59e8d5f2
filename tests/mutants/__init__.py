"""Faulty servers, clients and robots, each wrong in one known way: the proof that `hilbench check` can fail.

``python -m tests.mutants`` runs each of them against its suite and makes ``docs/mutants.json`` and ``docs/mutants.md``.
"""
