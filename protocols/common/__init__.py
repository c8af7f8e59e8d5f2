"""What protocols have in common: how their frames are shown, byte by byte, by those who only look at a line."""
