"""Right peers, of three kinds, that no clause may accuse."""
