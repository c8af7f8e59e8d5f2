"""Behavioural models of robot controllers."""
