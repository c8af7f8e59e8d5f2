"""Wrong peers made from what a protocol says of itself: its frames, their fields, its checksum, its tables and timers.

A relay stands on the line between the checker and a right peer and turns it into a wrong one. Which messages there are,
and which fields they have, is taken from what a right peer and the checker say to each other in the suites
(`measure.mutants.derived.tape`), read by the protocol's own decoder: no protocol is named here, and any plug-in gets
its wrong peers in this way.
"""
