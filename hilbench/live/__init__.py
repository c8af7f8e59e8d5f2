"""A bench that lives beside a dashboard, in a process of its own: it reports by its journal and obeys by a socket.

`session` puts one together and runs it, with the bench's `state_reporter`, by which the journal holds what a state
machine, a line and the host's clock do; `rigs` builds what stands on it; `tap` is the operator's end of a line, where
faults are put in; `driver` is who drives; `control` is the socket; `folders` says where all that is found again. `tied`
runs a command that must not outlive a dashboard.
"""
