# From a clone to a plan: `make demo`. From a change to a green run: `make test`. All targets: `make help`.
# Needs Python >= 3.10, make and g++ with C++20; everything else comes from PyPI into .venv.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMPS := .stamps
JOBS ?= 2
NATIVE := CMakeLists.txt $(wildcard native/*)
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check --no-input
say = @printf '== %s\n' "$(1)"
# The folder of the build, and its options.
compile = mkdir -p $(1) && { $(BIN)/cmake -S . -B $(1) -G Ninja -DCMAKE_MAKE_PROGRAM="$(CURDIR)/$(BIN)/ninja" \
  -DPython_EXECUTABLE="$(CURDIR)/$(BIN)/python" $(2) && $(BIN)/cmake --build $(1); } > $(1)/log || { cat $(1)/log; exit 1; }

.DEFAULT_GOAL := build
.DELETE_ON_ERROR:
.PHONY: help build demo test lint types imports unit sanitize sanitize-all fuzz fuzz-readers mutants bench paper \
  native clean

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-12s %s\n", $$1, $$2 }' Makefile

# --- environment: each step leaves a stamp, so what is done is not done again ---

$(STAMPS)/venv:
	$(call say,environment in $(VENV))
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	  { echo 'mitlplan needs Python 3.10 or later; name one with: make PYTHON=/path/to/python3'; exit 1; }
	@$(PYTHON) -m venv --clear $(VENV) > $(VENV).log 2>&1 || \
	  { echo '$(PYTHON) cannot make a virtual environment (its module venv or ensurepip is missing);' \
	    'install it, on Debian and Ubuntu with: apt install python3-venv'; rm -f $(VENV).log; exit 1; }
	@rm -f $(VENV).log
	@$(PIP) install --upgrade 'pip>=25.1'
	@mkdir -p $(STAMPS) && touch $@

$(STAMPS)/build: $(STAMPS)/venv pyproject.toml $(NATIVE)
	$(call say,install mitlplan and compile its native half)
	@$(PIP) install --editable '.[all]'
	@touch $@

$(STAMPS)/dev: $(STAMPS)/build pyproject.toml
	$(call say,install the tools of development)
	@$(PIP) install --group dev
	@touch $@

build: $(STAMPS)/build ## the package in .venv (the default)

# --- use ---

demo: build ## plan two example missions and keep plans and pictures in plans/
	@mkdir -p plans
	@for mission in docs/trajectory/phi1.yaml examples/warehouse.yaml; do \
	  printf '== mitlplan plan %s\n' $$mission; \
	  name=plans/$$(basename $$mission .yaml); \
	  $(BIN)/mitlplan plan $$mission && \
	  $(BIN)/mitlplan plan $$mission --format json --output $$name.json && \
	  $(BIN)/mitlplan draw $$mission $$name.json --output $$name.png || exit 1; \
	done
	$(call say,kept in plans/)

# --- checks ---

test: lint types imports unit sanitize ## everything that must be green

lint: $(STAMPS)/dev ## ruff: rules and format
	$(call say,ruff)
	@$(BIN)/ruff check --quiet
	@$(BIN)/ruff format --quiet --check

types: $(STAMPS)/dev ## mypy --strict
	$(call say,mypy)
	@$(BIN)/mypy --no-error-summary

imports: $(STAMPS)/dev ## who may import whom
	$(call say,import-linter)
	@$(BIN)/lint-imports --no-cache > $(STAMPS)/imports.log || { cat $(STAMPS)/imports.log; exit 1; }

unit: $(STAMPS)/dev ## pytest, with the examples in the docstrings
	$(call say,pytest)
	@$(BIN)/pytest --quiet -n $(JOBS)

# The interpreter is not instrumented, so the runtimes of the sanitizers, and the C++ runtime whose exceptions they
# watch, are loaded before it. It does not free everything at its end: leaks are not looked for.
PRELOAD = $(foreach library,libasan.so libubsan.so libstdc++.so,$(shell $(CXX) -print-file-name=$(library)))

$(STAMPS)/sanitize: $(STAMPS)/dev $(NATIVE)
	$(call say,compile the native half with sanitizers)
	@$(call compile,build/sanitize,-DMITLPLAN_SANITIZE=ON)
	@touch $@

# The programs that tests start are sanitized too: Python takes tests/sanitized/sitecustomize.py when it starts.
SANITIZED = LD_PRELOAD="$(PRELOAD)" ASAN_OPTIONS=detect_leaks=0 MITLPLAN_NATIVE="$(CURDIR)/build/sanitize" \
  PYTHONPATH="$(CURDIR)/tests/sanitized" $(BIN)/pytest --quiet -n $(JOBS)

sanitize: $(STAMPS)/sanitize ## the tests of the native half, under the address and undefined behaviour sanitizers
	$(call say,pytest under sanitizers)
	@$(SANITIZED) tests/native tests/search

# But for the comparisons with collocation: CasADi opens its solvers with RTLD_DEEPBIND, where the address sanitizer
# ends the process. None of them calls the native half.
sanitize-all: $(STAMPS)/sanitize ## every test that can be, under the sanitizers
	$(call say,pytest under sanitizers, all of it)
	@$(SANITIZED) --timeout=600 --ignore=tests/trajectory/test_collocation.py

fuzz: $(STAMPS)/dev ## random missions without end, other ones every time, put to every voice
	@$(BIN)/mitlplan-fuzz --seed $$(date +%s) --jobs $(JOBS)

SECONDS ?= 600

$(STAMPS)/fuzz: $(STAMPS)/dev pyproject.toml
	@$(PIP) install --group fuzz
	@touch $@

fuzz-readers: $(STAMPS)/fuzz ## every reader of files, guided by coverage, SECONDS each
	@$(BIN)/mitlplan-fuzz --readers --seconds $(SECONDS)

$(STAMPS)/mutants: $(STAMPS)/dev pyproject.toml
	@$(PIP) install --group mutants
	@touch $@

mutants: $(STAMPS)/mutants ## faults put into logic, translation and search, and which of them no test notices (an hour)
	@$(BIN)/python -m tests.mutants

$(STAMPS)/bench: $(STAMPS)/build benchmarks/requirements.txt
	$(call say,install the peers)
	@$(PIP) install --requirement benchmarks/requirements.txt
	@touch $@

bench: $(STAMPS)/bench ## measure beside the peers, and write docs/performance.md
	@$(BIN)/python -m benchmarks.performance

FIGURES = fig1 fig2 fig4 fig5 fig6 fig7 fig8 fig9

paper: $(STAMPS)/dev ## the paper's figures and Table I, and the faults of its construction, in docs (minutes)
	$(call say,figures)
	@for figure in $(FIGURES); do \
	  $(BIN)/mitlplan draw --figure $$figure --output docs/figures/$$figure.svg || exit 1; \
	done
	$(call say,tables)
	@$(BIN)/python -m benchmarks.paper_table

native: $(STAMPS)/dev ## compile the native half only, incrementally
	@$(call compile,build/native,-DMITLPLAN_IN_SOURCE=ON)

clean: ## forget everything that can be made again
	rm -rf $(VENV) $(STAMPS) build dist plans src/mitlplan/_core*.so src/mitlplan/_core.pyi
