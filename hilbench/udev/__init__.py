"""The udev rules that come with hilbench: what they say, what they do, how they are installed."""
