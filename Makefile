# Two commands need nothing but Python >= 3.11 and make: `make demo` and `make test`.
PYTHON ?= python3
BIN := .venv/bin
SETUP := .venv/.installed

# Every version that is installed, with the hashes of its files; `make lock` renews it.
LOCK := requirements.lock
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: setup demo test lint types warm unit lock audit format docs site paper dist studies bench nested fuzz clean

setup: $(SETUP)

$(SETUP): pyproject.toml $(LOCK)
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "stribeck needs Python 3.11 or newer: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv .venv
	$(PIP) --require-hashes --requirement $(LOCK)
	$(PIP) --no-deps --no-build-isolation --editable .
	touch $@

demo: setup
	$(BIN)/python tools/demo.py

# Types are looked at while laws and motions are compiled, each on one core.
test: setup
	$(MAKE) --jobs=2 lint types warm
	$(MAKE) unit

lint: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: setup
	$(BIN)/mypy

# Once for the hundreds of processes that the tests start: also where Python may write no bytecode.
warm: setup
	-$(BIN)/python -m compileall -q src
	-$(BIN)/stribeck warm

unit: setup
	$(BIN)/pytest

# Resolves the versions anew, for every Python and platform; tools of its own, outside the project.
lock:
	$(PYTHON) -m venv .venv/lock
	.venv/lock/bin/python -m pip install --quiet --disable-pip-version-check 'uv>=0.9,<1'
	.venv/lock/bin/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
		--no-emit-index-url --no-annotate --no-header --all-extras --upgrade \
		--output-file $(LOCK) pyproject.toml

# Patterns of weakness in the source, and known weaknesses of what is locked.
audit:
	$(PYTHON) -m venv .venv/audit
	.venv/audit/bin/python -m pip install --quiet --disable-pip-version-check \
		'bandit>=1.8,<2' 'pip-audit>=2.9,<3'
	.venv/audit/bin/python tools/audit.py $(LOCK) src tools benchmarks

# Renews every block of output in the README and the docs, and their figures.
docs: demo
	cp demo/left/training.png docs/figures/readme.png
	$(BIN)/python tools/architecture_figure.py
	$(BIN)/python tools/physics_figures.py
	$(BIN)/python tools/law_figures.py
	STRIBECK_PICTURES=docs/figures $(BIN)/pytest -q -n0 tests/test_studio_page.py tests/test_studio_ways.py \
		-k "drawn_as_it_goes or twincat-Mouse"
	$(BIN)/python tools/docs.py
	$(BIN)/python tools/api_reference.py
	$(BIN)/python tools/notebooks.py
	cp demo/compensation/compensation.png docs/figures/compensation.png

# The pages as a site in site/, with a search; a warning is an error.
site: setup
	$(BIN)/sphinx-build --nitpicky --fail-on-warning --keep-going --quiet -b html docs site

# The article in paper/, its tables by the commands that it names.
paper: setup
	$(BIN)/python tools/docs.py paper/paper.md

# Wheel and sdist, checked, and tried without the repository on every Python found of 3.11 to 3.14.
dist: setup
	$(BIN)/python tools/dist.py $(ARGS)

# The slow studies whose results are committed in docs/data: an hour and more.
studies: setup
	$(BIN)/python tools/kernel_study.py
	$(BIN)/python tools/twin_study.py 20
	$(BIN)/python tools/study.py paper
	$(BIN)/python tools/study.py twins
	$(BIN)/python tools/study.py bbob
	$(BIN)/python tools/engines_study.py

# What is claimed of speed, measured side by side: an hour and more. ARGS=--quick, ARGS='--only NAME'.
bench: setup
	$(BIN)/python benchmarks/run.py $(ARGS)

# Laws that contain each other, on measured servos: hours for all, kept fit by fit.
# ARGS='xl330 --laws m1,m4 --seeds 1'.
nested: setup
	$(BIN)/python benchmarks/nested_laws.py $(ARGS)

# Damaged inputs for everything that reads, see docs/reliability.md. ARGS='--seconds 3600 --seed 7'.
fuzz: setup
	$(BIN)/python tools/fuzz.py fuzz $(ARGS)

format: setup
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf .venv demo fuzz site jupyter_execute
