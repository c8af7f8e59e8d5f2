"""What the dashboard costs a bench whose line is full both ways; ``python -m measure.dashboard_load``."""
