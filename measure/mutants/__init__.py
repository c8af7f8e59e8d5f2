"""Faulty servers, clients and robots, each wrong in one known way: the proof that `hilbench check` can fail.

``python -m measure.mutants`` runs each of them against its suite and makes ``mutants.json`` and ``mutants.md`` in docs.
"""
