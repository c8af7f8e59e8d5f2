"""What the simulator's side must do, faced with a board of a script: what it commands the car, what it says of it.

Our own is told what its car does, and tells what the car was commanded. Of a foreign one only its statuses are seen.
"""

from __future__ import annotations

ORDER = ("commands", "damaged", "values", "whose_command", "silence", "statuses", "with_a_board")
