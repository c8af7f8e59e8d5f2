"""Recordings in the formats of other programs: MCAP, pcapng, VCD and CSV, written from a journal and read back."""
