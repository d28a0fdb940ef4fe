# `make demo` sets everything up and runs the main job; `make test` sets everything up and runs the tests.
# Needed: Python 3.11 or newer, and make. Everything else goes into .venv, and stays there.

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

VENV := .venv
BIN := $(VENV)/bin
OLDEST := 11
# Byte code at once: where Python is told to write none, every start would compile every module anew.
COMPILED := $(BIN)/python -m compileall -q saoflow verification

.PHONY: help demo test lint docs clean

help:
	@echo "make demo   set up, and run the main job: a flight with a fault, from YAML to a report in out/"
	@echo "make test   set up, and run the tests"
	@echo "make docs   set up, and build the documentation into out/documentation/site"
	@echo "make clean  remove the set-up"

demo: $(VENV)/.installed
	@$(BIN)/saoflow demo

test: $(VENV)/.installed-test lint
	@$(BIN)/python -m pytest -n 2

lint: $(VENV)/.installed-test
	@$(BIN)/ruff check .
	@$(BIN)/mypy

docs: $(VENV)/.installed-test
	@$(BIN)/python -m verification.documentation

# A Python that is new enough, by name or as the default one; PYTHON=... chooses another.
$(BIN)/python:
	@for candidate in $(PYTHON) python3.14 python3.13 python3.12 python3.11 python3 python; do \
	  if "$$candidate" -c 'import sys; sys.exit(sys.version_info < (3, $(OLDEST)))' 2>/dev/null; then \
	    found="$$candidate"; break; fi; done; \
	if [ -z "$$found" ]; then \
	  echo "saoflow needs Python 3.$(OLDEST) or newer, and finds: $$(python3 --version 2>&1 || echo none)."; \
	  echo "Install it, or say where it is: make PYTHON=/path/to/python3.$(OLDEST)"; exit 1; fi; \
	echo "Setting up $(VENV) with $$($$found --version) ..."; \
	if ! "$$found" -m venv $(VENV); then \
	  rm -rf $(VENV); echo "$$found has no venv module: install it (Debian: apt install python3-venv)."; exit 1; fi

# Installed anew only when pyproject.toml has changed since. The test set-up contains the other.
$(VENV)/.installed: pyproject.toml | $(BIN)/python
	@echo "Installing saoflow and what it needs (once; a minute or so) ..."
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@$(COMPILED)
	@touch $@

$(VENV)/.installed-test: pyproject.toml | $(BIN)/python
	@echo "Installing saoflow and what its tests need (once; a few minutes) ..."
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@$(COMPILED)
	@touch $(VENV)/.installed $@

clean:
	rm -rf $(VENV) *.egg-info
