"""The dashboard: a view of a bench's journal, and a hand on the bench.

`model` turns events into what is known, `views` turns that into lines of text; neither knows Textual. `bench_process`
starts a bench and speaks to it. `panes` and `app` put it on a terminal. Nothing but the command line imports this.
"""
