"""Boards: what is soldered around a microcontroller, as data."""
