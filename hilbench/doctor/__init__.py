"""What `hilbench doctor` looks at: the software, the machine, the ports; what is wrong, and what to do about it."""
