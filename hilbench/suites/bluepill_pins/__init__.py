"""Does a robot do what the pins of a Blue Pill say, and do the pins say what the robot meets?

The validation experiments of the bachelor's thesis (section 5.4) with figures, and what else can be asked of the wires
between the board and the robot. Two ways lead from the pins to the same robot in the same world: straight to wheels and
sensors, as in the original's simulation, and over its adapter by P2OS, as on its real robot. The same images run on
both. Where the published programs have a quirk, a case holds the bench to the quirk and another, with the setting that
mends it, to what is sound.
"""

from __future__ import annotations

ORDER = ("motion", "distances", "encoders", "both_ways", "adapter", "pad_and_turns", "ramp", "board")
