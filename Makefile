# Two commands do everything from a bare Debian or Ubuntu with Python 3.11 or newer: `make check` and `make test`.
# PYTHON=python3.13 picks another interpreter; VENV=dir another environment.

VENV ?= .venv
BIN  := $(VENV)/bin

# Without its bytecode each of some hundred processes that the tests start compiles the whole product anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: check test lint types layers unit search bench soak mutants loss deadlines resync xrce-messages campaign docs clean

check:            ## the main job: the virtual Pioneer against its conformance suites
	@.ci/setup $(VENV)
	@exec $(BIN)/hilbench check pioneer

test:             ## the gate: what a change must pass (docs/testing.md); minutes
	@$(MAKE) --no-print-directory --jobs=2 --output-sync=target lint types layers collected
	@$(MAKE) --no-print-directory unit

# In a new clone it takes a while until pytest has rewritten the asserts of all tests: once, not in each worker. Later
# there is nothing to do: what has changed since is little.
.PHONY: collected
collected: dev
	@test -d tests/__pycache__ || $(BIN)/python -m pytest --collect-only -qq >/dev/null || $(BIN)/python -m pytest --collect-only -q

.PHONY: dev
dev:
	@.ci/setup $(VENV) dev

lint: dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: dev
	$(BIN)/mypy

layers: dev
	$(BIN)/lint-imports

unit: dev         ## on all cores; names what takes over a second
	$(BIN)/python -m pytest -n auto --dist worksteal --durations=10 --durations-min=1

.PHONY: exhaustive
exhaustive:       ## every test there is; an hour and more
	@.ci/setup $(VENV) dev,docs
	HILBENCH_EXHAUSTIVE=1 $(BIN)/python -m pytest -n auto --dist worksteal

.PHONY: gate-runs
gate-runs: dev    ## the gate twelve times: idle, beside busy loops, on one processor, as root in a closed folder, as a user; resumable
	$(BIN)/python -m measure.gate_runs

.PHONY: right-peers
right-peers: dev   ## right models, firmware and scripts, checked 100 times each: no clause may accuse one; hours, resumable
	$(BIN)/python -m measure.right_peers

.PHONY: gate-proof
gate-proof: dev   ## small defects put into the product, and what of them the gate finds (docs/gate-proof.md); three hours, resumable
	$(BIN)/python -m measure.gate_proof

search: dev       ## the property tests again, with examples nobody has seen
	HILBENCH_SEARCH=1 $(BIN)/python -m pytest -n auto --dist worksteal

bench: dev        ## speed, as ratios against something run beside it
	$(BIN)/python -m pytest measure/benchmarks -s

soak: dev         ## ten million bytes into both roles, whole and byte by byte; 10^9 through the links; a megabyte through firmware on a pty
	$(BIN)/python -m pytest measure/soak -s

.PHONY: proxy-soak
proxy-soak: dev   ## 10^8 bytes, both ways together, between a ground station and the emulated rover, by a proxy; three hours
	$(BIN)/python -m measure.proxy_soak

.PHONY: dashboard-load
dashboard-load: dev ## what the dashboard costs a bench whose line is full both ways (docs/dashboard.md); a quiet machine, 4 minutes
	$(BIN)/python -m measure.dashboard_load

.PHONY: hardware
hardware: dev     ## what only a board or an adapter on the desk can prove (docs/hardware-tests.md): PORT=serial:... WITH=plug
	HILBENCH_HARDWARE_PORT='$(PORT)' HILBENCH_HARDWARE_WITH='$(WITH)' $(BIN)/python -m pytest tests/hardware

mutants: dev      ## the matrix clause x mutant (docs/mutants.md, docs/rover-defects.md)
	$(BIN)/python -m measure.mutants
	$(BIN)/python -m measure.mutants.rover

.PHONY: derived-mutants
derived-mutants: dev ## wrong peers made from what the protocols say of themselves (docs/derived-mutants.md); goes on where it was; a share of them
	$(BIN)/python -m measure.mutants.derived pkt-board --share 0.4
	$(BIN)/python -m measure.mutants.derived carla-board --share 0.5
	$(BIN)/python -m measure.mutants.derived p2os-server --share 0.2
	$(BIN)/python -m measure.mutants.derived pkt-host --share 0.5
	$(BIN)/python -m measure.mutants.derived p2os-client --share 0.2
	$(BIN)/python -m measure.mutants.derived carla-host --share 0.5

loss: dev         ## what newlines cost a client of the rover (docs/pkt/loss.md)
	$(BIN)/python -m measure.loss

deadlines: dev    ## how exactly a vehicle-interface board keeps its deadlines (docs/carla/deadlines.md)
	$(BIN)/python -m measure.deadlines

xrce-messages: dev ## a million reliable samples through the agent of DDS-XRCE, on lines with faults; an hour
	$(BIN)/python -m measure.xrce_messages

resync: dev       ## what stray bytes cost a vehicle-interface board (docs/carla/resync.md)
	$(BIN)/python -m measure.resync

.PHONY: doors
doors: dev        ## suites on boards in memory and through each door (docs/doors-verdicts.md): whole suites in virtual time, an hour, and parts in real time, half an hour, on an idle host
	$(BIN)/python -m measure.doors --whole
	$(BIN)/python -m measure.doors

campaign: dev     ## the dodger in twenty rooms, in three ways (docs/bluepill.md); half an hour
	$(BIN)/hilbench campaign examples/campaigns/dodger.toml --html dodger.html

.PHONY: drive-plots
drive-plots: dev  ## a lap and an emergency stop of a car (docs/vehicle-drive.md); two minutes
	$(BIN)/python -m measure.drive_plots

.PHONY: truth
truth: dev        ## each physics against formulas, and random drives in a thousand rooms (docs/physics.md); a quarter of an hour
	$(BIN)/python -m measure.physics_truth
	$(BIN)/python -m measure.random_drives

.PHONY: oracles
oracles: dev      ## a million sequences of instructions on each core, and of operands on each floating-point operation, beside Unicorn; hours, resumable
	$(BIN)/python -m measure.oracles

.PHONY: plots
plots:            ## the rover's wheels after throttles and set points (docs/rover-motion.md); five minutes
	@.ci/setup $(VENV) dev,plots
	$(BIN)/python -m measure.rover_plots

.PHONY: wheels
wheels:           ## manylinux wheels for x86-64 and ARM into dist, cross-compiled with the compiler of PyPI's ziglang
	@.ci/setup $(VENV) wheels
	HILBENCH_WHEEL_MACHINE=x86_64 $(BIN)/python -m build --wheel --no-isolation
	HILBENCH_WHEEL_MACHINE=aarch64 $(BIN)/python -m build --wheel --no-isolation

docs:             ## write anew what the docs take from the code, and serve them as a site: http://127.0.0.1:8000
	@.ci/setup $(VENV) dev,docs
	$(BIN)/python docs/generate.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs serve --strict --config-file docs/site/mkdocs.yml

.PHONY: site
site:             ## the site as files in build/site, which need no server but for the search
	@.ci/setup $(VENV) dev,docs
	$(BIN)/python docs/generate.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --config-file docs/site/mkdocs.yml

clean:
	rm -rf $(VENV) build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
