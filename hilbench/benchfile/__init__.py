"""Bench files: what stands in one, and what it means; and what a TARGET means."""
