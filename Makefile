# `make demo` and `make test` each set up everything they need on a machine that has
# Python 3.11 or later, pip and make. Another Python: make test PYTHON=python3.12

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# The pip of PYTHON works on .venv: Debian's Python has no ensurepip to put one inside.
PIP := "$(PYTHON)" -m pip --python $(BIN)/python --disable-pip-version-check --quiet

# A sourced ROS 2 puts its packages and pytest plugins on this path.
unexport PYTHONPATH PYTHONHOME

.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help demo test lint types tests bench clean FORCE

help:
	@echo "make demo    simulate some robots, replay a log, leave pictures in gallery/"
	@echo "make test    lint, types, and all tests"
	@echo "make lint    ruff alone          make types   mypy alone"
	@echo "make tests   pytest alone        make bench   benchmarks"
	@echo "make clean   remove .venv, gallery and caches"

demo: $(VENV)/.ready
	@$(BIN)/trundle demo --out gallery

test: lint types tests

lint: $(VENV)/.ready-dev
	@$(BIN)/python -m ruff check --quiet .
	@$(BIN)/python -m ruff format --check --quiet . || \
		{ echo "These files are not formatted; run: $(BIN)/python -m ruff format FILE"; \
		  $(BIN)/python -m ruff format --check . || exit 1; }
	@echo "ruff: clean"

types: $(VENV)/.ready-dev
	@$(BIN)/python -m mypy

tests: $(VENV)/.ready-dev
	@$(BIN)/python -m pytest --no-header -n auto --maxprocesses 4 $(PYTEST_ARGS)

bench: $(VENV)/.ready-dev
	@for script in benchmarks/[a-z]*.py; do $(BIN)/python "$$script" || exit 1; done

clean:
	rm -rf $(VENV) gallery build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# ---- set-up --------------------------------------------------------------------------------
# A stamp holds the checkout's path and is written when all is done. Set-up runs again when
# pyproject.toml is newer, when the checkout has moved, or when .venv's Python is gone.

NEW_ENOUGH := import sys; print("yes" if sys.version_info >= (3, 11) else "no")
VENV_STATE := $(shell [ "`cat $(VENV)/.ready 2>/dev/null`" = "$(CURDIR)" ] && \
	$(BIN)/python -c '$(NEW_ENOUGH)' 2>/dev/null)
STALE := $(if $(filter yes,$(VENV_STATE)),,FORCE)

# Says in a sentence what is missing, and how to get it.
define check_python
fail() { printf '%s\n' "$$@" >&2; exit 1; }; \
command -v "$(PYTHON)" >/dev/null 2>&1 || \
	fail "trundle needs Python 3.11 or later, and there is no '$(PYTHON)' here." \
		"Install one, or name it: make $(MAKECMDGOALS) PYTHON=/path/to/python3.12"; \
[ "`"$(PYTHON)" -c '$(NEW_ENOUGH)' 2>/dev/null`" = yes ] || \
	fail "trundle needs Python 3.11 or later, but '$(PYTHON)' is `"$(PYTHON)" --version 2>&1`." \
		"Install a newer one, or name it: make $(MAKECMDGOALS) PYTHON=python3.12"; \
"$(PYTHON)" -m pip --version >/dev/null 2>&1 || \
	fail "trundle needs pip, which '$(PYTHON)' does not have." \
		"Install it (on Debian and Ubuntu: sudo apt install python3-pip), then run make again."; \
"$(PYTHON)" -m pip --help 2>/dev/null | grep -q -e --python || \
	fail "trundle needs pip 22.3 or later: $(PYTHON) -m pip install --upgrade pip"
endef

# Made anew when its Python does not work or is of another version (a pip that serves one may be
# too old for the other), when the checkout has moved, or when the set-up that made it never
# ended (.unfinished). A sound .venv made by other tools is kept.
VERSION := import sys; print(sys.version_info[:2])
define make_venv
if [ -e $(VENV)/.unfinished ] \
	|| [ "`$(BIN)/python -c '$(VERSION)' 2>/dev/null`" != "`"$(PYTHON)" -c '$(VERSION)'`" ] \
	|| [ "`cat $(VENV)/.ready 2>/dev/null || pwd`" != "`pwd`" ]; then \
	rm -rf $(VENV) && mkdir $(VENV) && touch $(VENV)/.unfinished && \
	"$(PYTHON)" -m venv --without-pip $(VENV) || exit 1; \
fi; \
echo "Setting up $(VENV) (once; about a minute) ..."
endef

$(VENV)/.ready: pyproject.toml $(STALE)
	@$(check_python)
	@$(make_venv)
	@$(PIP) install --editable .
	@rm -f $(VENV)/.unfinished
	@echo "$(CURDIR)" > $@

$(VENV)/.ready-dev: pyproject.toml $(STALE)
	@$(check_python)
	@$(make_venv)
	@$(PIP) install --editable '.[dev]' || { \
		echo "Trying without wpimath, numba and jax, which have no wheels for every machine ..."; \
		$(PIP) install --editable '.[test]'; }
	@rm -f $(VENV)/.unfinished
	@echo "$(CURDIR)" > $(VENV)/.ready
	@echo "$(CURDIR)" > $@
