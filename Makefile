# Shapery. `make help` lists what there is.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules

# An interpreter that the locked versions were resolved for; `make PYTHON=… setup` names another.
PYTHON ?= $(shell for p in python3.12 python3.11 python3 python; do \
	$$p -c 'import sys; sys.exit(not (3,11) <= sys.version_info[:2] <= (3,12))' 2>/dev/null && { echo $$p; break; }; done)
VENV := .venv
BIN := $(VENV)/bin
MEMBERS := shared/contracts shared/geometry shared/platform shared/client \
	services/gateway services/segmentation services/retrieval services/motion worker
DASHBOARD := services/dashboard
STATIC := services/gateway/shapery_gateway/static
PYTEST := $(BIN)/python -m pytest
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: help setup demo up test test-fast check format schema lock bench bench-motion bench-segmentation bench-retrieval clean

help: ## show this list
	@grep -hE '^[a-z-]+:.*## ' Makefile | sed -E 's/:.*## /\t/' | expand -t 16

setup: $(VENV)/.ready $(STATIC)/.built ## set up everything (done by itself before the other targets)

$(VENV)/.python:
	@test -n "$(PYTHON)" || { echo "Python 3.11 or 3.12 is needed: put it on the PATH, or run make PYTHON=/path/to/python setup"; exit 1; }
	@echo "setting up in $(VENV) with $$($(PYTHON) --version)"
	@$(PYTHON) -m venv $(VENV) || { echo "Python lacks its venv module; on Debian: apt-get install python3-venv"; exit 1; }
	@touch $@

$(VENV)/.locked: requirements.lock | $(VENV)/.python
	$(BIN)/python -m pip install --quiet --require-hashes -r requirements.lock
	@touch $@

$(VENV)/.ready: $(VENV)/.locked $(MEMBERS:%=%/pyproject.toml)
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation $(MEMBERS:%=-e %)
	@echo "compiling the numerical kernels (once)"
	@printf '%s\n' segmentation retrieval motion | xargs -P 2 -I '{}' $(BIN)/python -m 'shapery_{}.warm'
	@touch $@

# The dashboard is built by the system's Node.js if that is recent enough, else by one from the Python registry.
$(STATIC)/.built: $(shell find $(DASHBOARD) -type f -not -path '*/node_modules/*' -not -path '*/dist/*' 2>/dev/null) | $(VENV)/.locked
	@deploy/dashboard.sh $(BIN)/python build
	@touch $@

demo: setup ## run the main job end to end on the embedded platform (ONCE=1 exits afterwards; VOLUME_PRE=, VOLUME_POST= for real files)
	@$(BIN)/python -m demo $(if $(ONCE),--once) $(if $(VOLUME_PRE),--pre "$(VOLUME_PRE)") $(if $(VOLUME_POST),--post "$(VOLUME_POST)")

up: setup ## start the platform on this machine and keep it running
	@$(BIN)/shapery up

test: setup ## run all tests
	@deploy/dashboard.sh $(BIN)/python test
	$(PYTEST) -n 2 --dist loadfile --no-loadscope-reorder

test-fast: $(VENV)/.ready ## run the tests that need neither servers nor a browser, but for whole pipelines
	@deploy/dashboard.sh $(BIN)/python test
	$(PYTEST) -n 2 --dist loadfile --no-loadscope-reorder -m "not server and not browser and not slow"

check: $(VENV)/.ready ## lint, types, layers, schema drift
	@deploy/dashboard.sh $(BIN)/python check
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/python -m shapery_gateway.schema --check

format: $(VENV)/.ready ## mend what the linter can mend
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	@deploy/dashboard.sh $(BIN)/python format

schema: $(VENV)/.ready ## write api_schema/ anew
	$(BIN)/python -m shapery_gateway.schema
	@deploy/dashboard.sh $(BIN)/python api

lock: $(VENV)/.locked ## resolve the locked versions anew (UPGRADE=1 takes newer ones)
	$(BIN)/python -m pip install --quiet uv
	deploy/lock.sh $(BIN)/uv $(if $(UPGRADE),--upgrade)

bench: setup bench-segmentation ## measure: segmentation beside peers, upload memory, searches over HTTP, the dashboard
	$(BIN)/python -m benchmarks.upload_memory
	$(BIN)/python -m benchmarks.dashboard
	$(BIN)/python -m benchmarks.search_over_http

bench-motion: setup ## measure motion compression beside its peers; takes long, goes on where it was stopped (BENCH=options)
	$(BIN)/python -m benchmarks.motion $(BENCH)

bench-segmentation: setup ## measure segmentation: real cases, peers, phantoms, growth (goes on where it stopped)
	$(BIN)/python -m benchmarks.segmentation $(BENCH)

bench-retrieval: setup ## measure retrieval: figures and table, peers, wear, parts, cost, growth (goes on where it stopped; BENCH="parts of it")
	$(BIN)/python -m benchmarks.retrieval $(BENCH)

clean: ## remove what set-up and builds made
	rm -rf $(VENV) $(STATIC) $(DASHBOARD)/node_modules $(DASHBOARD)/dist .mypy_cache .ruff_cache .pytest_cache
