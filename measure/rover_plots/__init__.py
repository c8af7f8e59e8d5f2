"""How the rover's wheels follow throttles and set points, beside what the original did. ``make plots``."""
