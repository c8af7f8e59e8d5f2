"""The vehicle and its surroundings: scenes, physics and sensors in SI units behind one narrow interface."""
