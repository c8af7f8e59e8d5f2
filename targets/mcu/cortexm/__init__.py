"""A Cortex-M3 without its instructions: exceptions, interrupts, faults, sleep, and the private peripheral bus."""
