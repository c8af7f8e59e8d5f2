"""What the dashboard costs a bench whose line is full both ways; ``python -m tests.dashboard_load``."""
