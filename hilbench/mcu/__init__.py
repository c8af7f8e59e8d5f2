"""Emulated boards on the bench: their time, their lines and wires, what is recorded of them, and their commands."""
