"""The rover."""
