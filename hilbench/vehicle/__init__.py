"""The vehicle interface on a bench: both its lines, the hands on its board, and the car."""
