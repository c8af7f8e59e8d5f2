"""Programs that measure the project itself; they stand beside the tests, and no part of them is in the wheel."""
