"""Verdicts: what they rest on, what casts doubt on them, and what is gathered for them."""
