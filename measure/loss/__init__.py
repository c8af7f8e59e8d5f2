"""How many reports a client loses that takes lines for frames: measured, and against the formula.

``python -m measure.loss`` makes ``docs/pkt/loss.md`` and its picture.
"""
