"""The autonomous car with its vehicle-interface board."""
