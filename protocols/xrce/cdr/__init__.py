"""CDR, and the messages of ROS in it."""
