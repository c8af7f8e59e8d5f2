"""The serial ports of this machine: what is plugged in, who has it, how to find it again."""
