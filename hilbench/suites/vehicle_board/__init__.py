"""What a vehicle-interface board must do: every case of its catalogue, each in the profiles that hold it.

A case brings the board into a mode, changes one thing, and looks at the frames to the simulator, at the reports to the
driving stack, and at what somebody beside the board sees. One file for each thing that it has to do.
"""
