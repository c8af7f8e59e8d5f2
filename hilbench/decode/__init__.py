"""`hilbench decode`: bytes of a line, as frames that can be read."""
