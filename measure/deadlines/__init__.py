"""How exactly a vehicle-interface board keeps its deadlines: measured at many phases, against what is documented."""
