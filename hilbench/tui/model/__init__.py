"""What is known of a bench, made of the events of its journal alone."""
