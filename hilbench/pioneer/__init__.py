"""The Pioneer on a bench: the virtual robot, a client, and a server in the hands of a case."""
