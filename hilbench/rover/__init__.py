"""The rover on a bench: what a case may touch, both ends of its line, and what is observed."""
