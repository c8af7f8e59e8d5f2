"""A bench that lives beside a dashboard, in a process of its own: it tells by its journal and obeys by a socket.

`session` puts one together and runs it; `rigs` builds what stands on it; `teller` lets the journal hold what a state
machine, a line and the host's clock do; `tap` is the operator's end of a line, where faults are put in; `driver` is who
drives; `control` is the socket; `folders` says where all that is found again. `tied` runs a command that must not
outlive a dashboard.
"""
