"""Benches of any protocol: what a plug-in brings stands in them, and nothing here knows which one that is."""
