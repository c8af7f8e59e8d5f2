"""Campaigns: one check at many points, of seeds, images, benches, faults and settings, and what that shows."""
