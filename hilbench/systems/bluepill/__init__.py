"""Firmware on a Blue Pill that drives a robot by its pins, or through an adapter."""
