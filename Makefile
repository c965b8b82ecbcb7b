# make demo   the main job on a sample, or on FILE=...
# make test   everything that must hold
# Both set up what they need in .venv first; python3 (3.11 or later), pip and make are enough.

PYTHON ?= python3
FILE   ?= examples/tactical_gyro.csv
ARGS   ?=
OUT    := build/demo
BIN    := .venv/bin
THREADS := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

.PHONY: help demo test lint setup clean

help:
	@echo "make demo              find the noise of an embedded sample"
	@echo "make demo FILE=path    ... of your own record; options of 'allanite analyze' go into ARGS='--rate 100 --unit deg/s'"
	@echo "make test              lint, types, layers and all tests"
	@echo "make clean             remove .venv, build and caches"

demo: .venv/run
	@mkdir -p $(OUT)
	@$(BIN)/allanite analyze "$(FILE)" --report $(OUT)/report.html --plot $(OUT)/curve.png --force $(ARGS)

test: lint
	$(THREADS) $(BIN)/python -m pytest -n 2 -q

lint: .venv/test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

setup: .venv/test

.venv/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "allanite needs Python 3.11 or later, and '$(PYTHON)' is older or missing; try: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -m venv .venv 2>/dev/null || $(PYTHON) -m virtualenv -q .venv 2>/dev/null || \
	  { rm -rf .venv; echo "'$(PYTHON)' has no working venv module. Install it and run make again:" >&2; \
	    echo "  Debian, Ubuntu:  apt install python3-venv" >&2; \
	    echo "  others:          $(PYTHON) -m pip install --user virtualenv" >&2; exit 1; }

.venv/run: .venv/bin/python pyproject.toml constraints.txt
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt -e .
	@touch $@

.venv/test: .venv/bin/python pyproject.toml constraints.txt
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt -e '.[test]'
	@touch .venv/run $@

clean:
	rm -rf .venv build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
