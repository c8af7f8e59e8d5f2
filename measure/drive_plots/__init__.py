"""A lap and an emergency stop of a car that an emulated vehicle-interface board drives: figures and pictures.

``python -m measure.drive_plots`` makes ``docs/vehicle-drive.md`` and its pictures.
"""
