# make demo       the main job on a sample, or on FILE=...
# make quick      lint, types and the tests of what has changed
# make test       what must hold after every change
# make ci         what continuous integration runs
# make nightly    everything that must hold, with all examples
# make evidence   every table of the benchmarks, of the code as it is
# make docs       the documentation site
# Each sets up what it needs in .venv first; python3 (3.11 or later), pip and make are enough.

PYTHON  ?= python3
FILE    ?= examples/tactical_gyro.csv
ARGS    ?=
NIGHT   ?=
TABLES  ?=
SINCE   ?= HEAD
PYTHONS ?= $(foreach v,3.11 3.12 3.13 3.14,$(if $(shell command -v python$(v)),python$(v)))
OUT     := build/demo
BIN     := .venv/bin
PIP     := $(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt
THREADS := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

# so that the many processes of the tests do not compile the package again
unexport PYTHONDONTWRITEBYTECODE

# through the environment, so that blanks, quotes and dollars in a name reach the program as they are
export FILE

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo quick test ci nightly evidence lint docs pages catalogues matrix release article setup clean

help:
	@echo "make demo              find the noise of an embedded sample"
	@echo "make demo FILE=path    ... of your own record; options of 'allanite analyze' go into ARGS='--rate 100 --unit deg/s'"
	@echo "make quick             lint, types and the tests of the packages that have changed since SINCE=HEAD"
	@echo "make test              lint, types, layers and the tests that every change has to pass"
	@echo "make ci                the same, and long records, processes, the page in a browser and the site"
	@echo "make nightly           everything, with all examples: hours; NIGHT='browser site' for parts"
	@echo "make evidence          make every table of the benchmarks again: hours; TABLES='speed fuzz' for some, TABLES=--all for all"
	@echo "make lint              lint, types and layers only"
	@echo "make docs              build the documentation site into build/site"
	@echo "make matrix            try the wheel with other Pythons and dependencies: build/environments.md"
	@echo "make release           sdist, wheel, bill of materials and checksums into dist"
	@echo "make article           the figure of paper/paper.md"
	@echo "make pages             bring what README and pages show of commands up to date"
	@echo "make catalogues        bring the translations of the reports up to date with the source"
	@echo "make setup             only set up .venv, with everything the tests need"
	@echo "make clean             remove .venv, build and caches"
	@echo "PYTHON=python3.12      behind any of these: another Python than python3 (for a new .venv)"

demo: .venv/run
	@mkdir -p $(OUT)
	@$(BIN)/allanite analyze --report $(OUT)/report.html --plot $(OUT)/curve.png --force $(ARGS) -- "$$FILE"

PYTEST  := $(THREADS) $(BIN)/python -m pytest -n auto --dist worksteal -q

LINT    := $(BIN)/ruff check . && $(BIN)/ruff format --check . && $(BIN)/mypy && $(BIN)/lint-imports --no-cache && \
  $(BIN)/python tools/words.py && $(BIN)/python tools/catalogues.py --check && \
  $(BIN)/python tools/stale.py --check && $(BIN)/python tools/figures.py --check

# the kernels are compiled beside the checks
READY   := $(THREADS) $(BIN)/python tools/kernels.py & made=$$!; { $(LINT); } || { kill $$made; exit 1; }; wait $$made

# a selection that is empty, or has long tests only, is no failure
quick: lint
	@tests=$$($(BIN)/python tools/changed.py $(SINCE)); [ -z "$$tests" ] || \
	  $(PYTEST) -m "not slow and not nightly" $$tests || [ $$? -eq 5 ]

test: .venv/test
	@$(READY)
	$(PYTEST) -m "not slow and not nightly"

ci: .venv/test
	@$(READY)
	$(PYTEST) -m "not nightly"

nightly: .venv/test
	$(BIN)/python tools/nightly.py $(NIGHT)

evidence: .venv/test
	$(BIN)/python tools/evidence.py $(TABLES)

lint: .venv/test
	@$(LINT)

docs: .venv/test
	@$(THREADS) $(BIN)/python -m sphinx -W --keep-going -q -b html docs build/site
	@echo "the documentation is in build/site/index.html"

# what is shown of commands, and the figures and tables of papers; the tests only compare
pages: .venv/test
	@$(BIN)/python tools/excerpts.py
	@$(BIN)/python tools/papers.py

catalogues: .venv/test
	@$(BIN)/python tools/catalogues.py

matrix: .venv/test
	@mkdir -p build
	$(BIN)/python benchmarks/environments.py --pythons $(PYTHONS) --write build/environments.md

release: .venv/release
	@$(BIN)/python tools/release.py dist
	@echo "the release is in dist"

# the figure of the article in paper/
article: .venv/run
	@$(BIN)/allanite analyze examples/tactical_gyro.csv --channels gz --plot paper/figure.png --force --quiet

setup: .venv/test

# A .venv that works is kept; the Python is asked what it can do before anything is written.
.venv/made:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	  echo "allanite needs Python 3.11 or later, and '$(PYTHON)' is older or missing." >&2; \
	  echo "Install one, or name it: make PYTHON=python3.12 ..." >&2; exit 1; }
	@if $(BIN)/python -m pip --version >/dev/null 2>&1; then :; \
	elif $(PYTHON) -c 'import ensurepip, venv' 2>/dev/null; then $(PYTHON) -m venv .venv; \
	elif $(PYTHON) -c 'import virtualenv' 2>/dev/null; then $(PYTHON) -m virtualenv -q .venv; \
	else \
	  echo "'$(PYTHON)' cannot make a virtual environment. Install what is missing, then run make again:" >&2; \
	  echo "  Debian, Ubuntu:  apt install python3-venv" >&2; \
	  echo "  Fedora:          dnf install python3 python3-pip" >&2; \
	  echo "  anywhere:        $(PYTHON) -m pip install --user virtualenv" >&2; exit 1; \
	fi
	@touch $@

.venv/run: .venv/made pyproject.toml constraints.txt
	@echo "installing allanite into .venv (once; it takes about 0.7 GB of disk)" >&2
	@$(PIP) -e .
	@touch $@

.venv/test: .venv/made pyproject.toml constraints.txt
	@echo "installing allanite and what its tests need into .venv (once)" >&2
	@$(PIP) -e '.[test,docs]'
	@$(THREADS) $(BIN)/python tools/kernels.py
	@touch .venv/run $@

.venv/release: .venv/test
	@$(PIP) -e '.[release]'
	@touch $@

clean:
	rm -rf .venv build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .import_linter_cache
