# Everything from a bare machine with Python 3.11 or newer and make: `make demo`, `make test`.

VENV   := .venv
PYTHON := $(VENV)/bin/python
# Of the language and of small parts: all but what drives thousands of scenes, or breaks thousands of programs.
SLOW   := $(patsubst %,tests/engine/test_%.py,avoidability fairness metrics sight verification) \
          tests/cortex_dsl/test_front_door.py tests/cortex_dsl/test_scenic_rows.py \
          tests/cortex_dsl/editor/test_server.py tests/cortex_dsl/semantics/test_robustness.py \
          tests/cortex_dsl/syntax/test_fuzz.py
QUICK  := tests/cortex_dsl/syntax tests/cortex_dsl/semantics tests/cortex_dsl/lowering tests/cortex_dsl/editor \
          tests/engine/road $(filter-out $(SLOW),$(wildcard tests/cortex_dsl/test_*.py tests/engine/test_*.py)) \
          tests/test_architecture.py tests/test_documents.py
SCENE  ?= examples/left_turn.scn
ARGS   ?=
# Each worker begins with a part of its own (tests/conftest.py), and takes over from the other when it is done.
PYTEST := $(PYTHON) -m pytest --numprocesses 2 --dist worksteal
PYTHONS := python3.14 python3.13 python3.12 python3.11 python3

# Tests start hundreds of processes, each a third sooner where Python may keep what it compiled.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test quick night lowest check format coverage docs wheel bench validate install dev clean help

help:
	@echo "make demo      set up, then search examples/left_turn.scn for collisions"
	@echo "make test      set up, then run the tests and the import contracts"
	@echo "make quick     the tests of the language and of small parts"
	@echo "make night     the tests, each law with 40 times as many examples, drawn anew"
	@echo "make lowest    the tests, with the lowest versions that pyproject.toml declares"
	@echo "make check     ruff, format, types and import contracts"
	@echo "make format    let ruff lay the code out"
	@echo "make coverage  run the tests, and say which lines none of them reaches"
	@echo "make docs      build the site from docs/ into build/site"
	@echo "make wheel     build a wheel with compiled kernels, and a source distribution, into dist"
	@echo "make bench     measure how fast it is"
	@echo "make validate  set up the checkers of other tools, once, and hold exports against them"
	@echo "make clean     remove everything that was set up"

# Each step says what it does, shows its progress, and ends with the seconds that it took.
demo:
	@echo "1/3 environment: a virtual environment in $(VENV), with the packages of pyproject.toml (once)"
	@start=$$(date +%s); $(MAKE) -s install && echo "    environment: $$(($$(date +%s) - start)) s"
	@echo "2/3 kernels: compile sampler and simulator to machine code (once for each version)"
	@start=$$(date +%s); $(PYTHON) -m wheels.prepare $(SCENE) && echo "    kernels: $$(($$(date +%s) - start)) s"
	@echo "3/3 search: cortexc $(SCENE) --ga $(ARGS)"
	@$(VENV)/bin/cortexc $(SCENE) --ga $(ARGS)

test: dev
	$(PYTEST) $(ARGS)

quick: dev
	$(PYTEST) --hypothesis-profile quick $(QUICK) $(patsubst %,--ignore=%,$(SLOW)) $(ARGS)

night: dev
	$(PYTEST) --hypothesis-profile night -o faulthandler_timeout=0 $(ARGS)

# In an environment of its own: are the lower bounds of pyproject.toml true?
lowest:
	$(MAKE) VENV=build/lowest PYTHONS=python3.11 build/lowest/bin/pip
	build/lowest/bin/python -m pip install --quiet --disable-pip-version-check uv
	build/lowest/bin/uv pip install --quiet --python build/lowest/bin/python --resolution lowest-direct --editable ".[dev]"
	@touch build/lowest/.installed build/lowest/.installed-dev
	$(MAKE) VENV=build/lowest test

check: dev
	$(VENV)/bin/ruff check
	$(VENV)/bin/ruff format --check
	$(VENV)/bin/basedpyright
	$(VENV)/bin/lint-imports

format: dev
	$(VENV)/bin/ruff check --fix
	$(VENV)/bin/ruff format

coverage: dev
	$(PYTEST) --cov --cov-report term:skip-covered --cov-report html:build/coverage $(ARGS)

docs: $(VENV)/.installed-docs
	$(PYTHON) -m docs.builder build/site $(ARGS)

wheel: dev
	rm -rf dist
	$(PYTHON) -m wheels.compile_kernels build/kernels
	CORTEXC_WHEEL_KERNELS=build/kernels $(PYTHON) -m hatchling build

bench: install
	$(PYTHON) -m benchmarks.speed $(ARGS)

validate: dev
	$(PYTHON) -m benchmarks.validation $(ARGS)
	$(PYTHON) -m benchmarks.adversary

install: $(VENV)/.installed
dev: $(VENV)/.installed-dev $(VENV)/.installed-schemas

# The stamps make a second run immediate; a change of pyproject.toml installs again.
$(VENV)/.installed: pyproject.toml | $(VENV)/bin/pip
	$(PYTHON) -m pip install --disable-pip-version-check --editable .
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(VENV)/bin/pip
	$(PYTHON) -m pip install --disable-pip-version-check --editable ".[dev]"
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-docs: pyproject.toml | $(VENV)/bin/pip
	$(PYTHON) -m pip install --quiet --disable-pip-version-check --editable ".[docs]"
	@touch $@ $(VENV)/.installed

# The tests judge exports by the schemas of the standards. Their packages want other versions than ours: no dependencies.
$(VENV)/.installed-schemas: tests/schemas.txt | $(VENV)/bin/pip
	@rm -rf $(VENV)/schemas
	$(PYTHON) -m pip install --quiet --disable-pip-version-check --no-deps --target $(VENV)/schemas --requirement tests/schemas.txt
	@touch $@

$(VENV)/bin/pip:
	@for python in $(PYTHONS); do \
	  if $$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
	    echo "setting up $(VENV) with $$python (once)"; \
	    $$python -m venv --clear $(VENV) && exit 0; \
	    echo "make: $$python cannot make a virtual environment; on Debian and Ubuntu install python3-venv" >&2; \
	    exit 1; \
	  fi; \
	done; \
	echo "make: cortexc needs Python 3.11 or newer, and none of $(PYTHONS) is" >&2; \
	exit 1

clean:
	rm -rf $(VENV) .validate .pytest_cache .ruff_cache .hypothesis .import_linter_cache build dist
