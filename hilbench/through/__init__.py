"""Lines that pass a door of this machine on their way, in virtual time.

What one end writes goes in at one side of the door and comes out at the other before time moves on: every byte takes
the way of a program's at that door, and a run is as repeatable as without.
"""

from hilbench.through.routes import Routes

__all__ = ["Routes"]
