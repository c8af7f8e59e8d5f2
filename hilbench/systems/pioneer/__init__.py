"""The Pioneer robots."""
