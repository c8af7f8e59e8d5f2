"""Twenty rooms, three ways: how the dodger fares beyond the rooms of the suite. ``make campaign``."""
