"""A bench that lives beside a dashboard, in a process of its own: it reports by its journal and obeys by a socket.

`session` puts one together and runs it, with the bench's `state_reporter`, by which the journal holds what a state
machine, a line and the host's clock do; `rigs` builds what stands on it, of taps, drivers and the socket of
`hilbench.driving`; `folders` says where all that is found again. `ends_with_parent` runs a command that must not
outlive a dashboard.
"""
