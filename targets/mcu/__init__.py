"""Emulated microcontrollers that run the very binary that would be flashed."""
