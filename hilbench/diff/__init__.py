"""`hilbench diff`: what the pins did in two recordings, side by side."""
