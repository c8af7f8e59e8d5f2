"""The library in C that emulates microcontrollers: its sources, how they are compiled, how it is loaded."""
