"""What a person at a terminal and the command have to do with each other: words, streams, signals."""
