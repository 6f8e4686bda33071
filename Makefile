# Everything a newcomer, a reviewer or a machine does with this project.
#   make demo      the nine-robot experiment, headless: pose log, figures, summary
#   make test      the test suite        make lint   style, types, import rules
#   make bench     every benchmark       make help   this list and the rest
# Each target builds the virtual environment it needs; a second call starts at once.

PYTHON ?= python3
VENV   ?= .venv
ifeq ($(OS),Windows_NT)
BIN    := $(VENV)/Scripts
EXE    := .exe
else
BIN    := $(VENV)/bin
EXE    :=
endif
# One BLAS thread: small matrices only lose time to more, and figures stay comparable.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1
# RECORD=1 adds what a benchmark measured to benchmarks/history/.
export BENCH_RECORD = $(RECORD)
export PIP_DISABLE_PIP_VERSION_CHECK = 1
# Tests start hundreds of Pythons: what all of them import is compiled once, also where an image says otherwise.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test docs docs-browser docs-links pictures wheel test-slow test-numpy1 test-portable coverage mutants lint bench bench-nine bench-rps bench-barriers bench-verify \
	bench-report bench-fuzz bench-faults bench-paper bench-machines bench-reality bench-batch bench-libraries bench-plot lock clean help
.DEFAULT_GOAL := help

help:  ## this list
	@awk -F ':.*## ' '/^[a-z0-9-]+:.*## /{printf "  make %-16s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

$(BIN)/python$(EXE):
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10) and f"posflock needs Python 3.10 or newer; {sys.executable} is {sys.version.split()[0]}: try  make PYTHON=python3.11")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.runtime: setup.cfg constraints.txt | $(BIN)/python$(EXE)
	$(BIN)/python -m pip install -q -c constraints.txt -e .
	@touch $@

$(VENV)/.dev: setup.cfg constraints.txt | $(BIN)/python$(EXE)
	$(BIN)/python -m pip install -q -c constraints.txt -e '.[dev]'
	@touch $@ $(VENV)/.runtime

$(VENV)/.release: setup.cfg constraints.txt | $(BIN)/python$(EXE)
	$(BIN)/python -m pip install -q -c constraints.txt -e '.[release]'
	@touch $@ $(VENV)/.runtime

$(VENV)/.docs: setup.cfg constraints.txt | $(BIN)/python$(EXE)
	$(BIN)/python -m pip install -q -c constraints.txt -e '.[docs]'
	@touch $@ $(VENV)/.runtime

demo: $(VENV)/.runtime  ## the nine-robot experiment on this machine: results/ holds log, figures, summary
	$(BIN)/python experiments/robotarium_9bot.py --out results

test: $(VENV)/.dev  ## the test suite
	$(BIN)/python -m pytest -n 2 --dist loadfile $(PYTEST_ARGS)

wheel: $(VENV)/.release  ## wheel and source archive in dist/, checked, and tried in new environments
	$(BIN)/python .ci/wheel.py $(WHEEL_ARGS)

docs: $(VENV)/.docs  ## the documentation as a site in build/docs/html: strict, links and names checked
	$(BIN)/python -m tools.documentation

docs-browser: docs $(VENV)/.dev  ## that site in Chromium: axe-core, wide and narrow, light and dark, its search
	$(BIN)/python -m pytest -m slow tests/test_built_site.py $(PYTEST_ARGS)

docs-links: $(VENV)/.docs  ## every address outside of the project that the documentation names (asks the network)
	$(BIN)/python -m tools.documentation --external

pictures: $(VENV)/.dev  ## the pictures of the documentation that show figure, report and live page, renewed
	$(BIN)/python tools/pictures.py

test-slow: $(VENV)/.dev $(VENV)/.release  ## the tests that take minutes
	$(BIN)/python -m pytest -m slow $(PYTEST_ARGS)

test-numpy1: $(VENV)/.dev  ## the test suite on NumPy 1.26, the oldest that is supported
	$(BIN)/python .ci/portable.py --environment numpy1 $(PYTEST_ARGS)

test-portable: $(VENV)/.dev  ## the tests as other processors, numpys and Pythons compute
	$(BIN)/python .ci/portable.py $(PYTEST_ARGS)

coverage: export COVERAGE_FILE = $(CURDIR)/.coverage
coverage: $(VENV)/.dev  ## the test suite, and what share of the code it runs, children included
	$(BIN)/coverage erase
	$(BIN)/coverage run -m pytest -n 2 --dist loadfile $(PYTEST_ARGS)
	$(BIN)/coverage combine -q
	$(BIN)/coverage report

mutants: $(VENV)/.dev  ## faults planted one by one: MUTANTS_ARGS="law --sample 40", or hours for all
	$(BIN)/python tools/mutants.py $(MUTANTS_ARGS)

lint: $(VENV)/.dev  ## ruff, mypy --strict, import rules, docstrings
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python tools/docstrings.py

bench: bench-nine bench-rps bench-barriers bench-verify bench-report bench-fuzz bench-faults bench-paper bench-machines bench-reality bench-batch bench-libraries  ## every benchmark

bench-nine: $(VENV)/.dev  ## the nine-robot experiment against its acceptance table
	$(BIN)/python benchmarks/nine_robots.py
	$(BIN)/python benchmarks/local_flock.py

bench-barriers: $(VENV)/.dev  ## certificates: speed against the common way; 200,000 steps under attack; late robots
	$(BIN)/python benchmarks/barrier_speed.py
	$(BIN)/python benchmarks/barrier_safety.py
	$(BIN)/python benchmarks/barrier_safety.py --steps 1632000 --teams 16 --engine numba
	$(BIN)/python benchmarks/decentralised.py
	$(BIN)/python benchmarks/staying_connected.py
	$(BIN)/python benchmarks/late_robots.py

bench-rps: $(VENV)/.dev  ## steps a second of both API generations, construction, plotting
	$(BIN)/python benchmarks/rps_speed.py

bench-verify: $(VENV)/.dev  ## the flock under imperfections; calibration against truth; cost of verify
	$(BIN)/python benchmarks/imperfect_robots.py
	$(BIN)/python benchmarks/calibration.py
	$(BIN)/python benchmarks/verify_cost.py

bench-report: $(VENV)/.dev  ## estimators against truth; cost of an analysis over a run's length
	$(BIN)/python benchmarks/estimator_truth.py
	$(BIN)/python benchmarks/gaps_truth.py
	$(BIN)/python benchmarks/band_coverage.py
	$(BIN)/python benchmarks/report_scaling.py
	$(BIN)/python benchmarks/replay_video.py

bench-fuzz: $(VENV)/.dev  ## twenty thousand damaged files through the readers of logs
	$(BIN)/python benchmarks/fuzz_readers.py

bench-faults: $(VENV)/.dev  ## 500 kills, full disks, hostile scripts in both containments, files that lie, long runs
	$(BIN)/python benchmarks/faults_kills.py
	$(BIN)/python benchmarks/faults_full_disk.py
	$(BIN)/python benchmarks/faults_hostile.py
	$(BIN)/python benchmarks/fuzz_structures.py
	$(BIN)/python benchmarks/faults_long_runs.py

bench-machines: $(VENV)/.dev  ## how far runs of one seed drift apart from machine to machine
	$(BIN)/python benchmarks/machine_differences.py

bench-paper: $(VENV)/.dev  ## the paper's table over seeds, what flocks and sweeps cost
	$(BIN)/python benchmarks/paper_table.py
	$(BIN)/python benchmarks/freespace_speed.py
	$(BIN)/python benchmarks/sweep_throughput.py

bench-batch: $(VENV)/.dev  ## thousands of teams at once: JAX=python-with-jax SIMULATOR=folder-of-rps_jax, else without
	$(BIN)/python benchmarks/batch_speed.py $(if $(JAX),--jax $(JAX) --simulator $(SIMULATOR))
	$(BIN)/python benchmarks/batch_growth.py $(if $(JAX),--jax $(JAX) --simulator $(SIMULATOR))
	$(BIN)/python benchmarks/batch_flock_speed.py

bench-libraries: $(VENV)/.dev  ## other libraries for barrier functions: LIBRARIES="--cbfpy python-that-has-it ...", else ours alone
	$(BIN)/python benchmarks/cbf_libraries.py $(LIBRARIES)

bench-reality: $(VENV)/.dev  ## predictions against real runs: REAL=folder of fetched repositories, else skipped
	$(BIN)/python benchmarks/reality.py $(REAL)

bench-plot: $(VENV)/.dev  ## what benchmarks measured over time, drawn into results/; RECORD=1 with any of them adds a row
	$(BIN)/python benchmarks/history.py

lock:  ## renew constraints.txt from the ranges in setup.cfg (needs uv)
	uv pip compile --universal --python-version 3.10 --extra dev --extra docs --extra release -c .ci/testbed.txt --no-annotate --no-header -q setup.cfg -o constraints.txt

clean:  ## remove environments and results
	rm -rf $(VENV) .venv-numpy1 .venv-testbed .venv-newest results build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis .coverage .coverage.*
