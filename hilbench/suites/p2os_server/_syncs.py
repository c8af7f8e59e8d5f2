"""The three packets of the handshake."""

from __future__ import annotations

SYNC0, SYNC1, SYNC2 = (bytes.fromhex(text) for text in ("FAFB03000000", "FAFB03010001", "FAFB03020002"))
