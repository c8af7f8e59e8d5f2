"""Lines that pass a door of this machine on their way, in virtual time.

What one end writes goes in at one side of the door and comes out at the other before time moves on. So the bytes have
been where those of a program at that door have been, and a run is as repeatable as without.
"""

from hilbench.through.passages import Passages

__all__ = ["Passages"]
