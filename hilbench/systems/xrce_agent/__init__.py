"""The agent of DDS-XRCE as a system: boards with micro-ROS connect to it, and to each other through it."""
