# make demo   set up, register bags/demo.mcap, judge it against its exact poses, draw a picture
# make test   set up, then every check and test
# PYTHON=python3.12 picks the interpreter, VENV=... the place of the environment.

VENV ?= .venv
PYTHON ?=
BIN := $(VENV)/bin
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
MAKEFLAGS += --no-builtin-rules

KERNELS := $(wildcard ros_rops/kernels/src/*.cpp ros_rops/kernels/src/*.hpp)
SETUP := setup.py pyproject.toml .ci/make_venv
OVERLAY := .ci/make_overlay $(wildcard .ci/overlay/*/* .ci/overlay/*/*/*)
CODE := ros_rops setup.py test .ci/generate.py .ci/draw_station.py $(wildcard msg_adapters launch)

.PHONY: help demo test lint format types pytest baseline generate clean
help:
	@sed -n 's/^# //p' Makefile | head -3

demo: $(VENV)/.ready
	$(BIN)/rops demo --out runs/demo

test: lint types pytest

lint: $(VENV)/.ready-test
	$(BIN)/ruff check $(CODE)

format: $(VENV)/.ready-test
	$(BIN)/ruff check --select I --fix $(CODE)

types: $(VENV)/.ready-test
	$(BIN)/mypy

pytest: $(VENV)/.ready-test
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m 'not alone'
	$(BIN)/python -m pytest -m alone

baseline: $(VENV)/.ready
	$(BIN)/rops bench short --json test/baseline/short.json

generate: $(VENV)/.ready
	$(BIN)/python .ci/generate.py

clean:
	rm -rf build dist install log .pytest_cache .mypy_cache .ruff_cache *.egg-info

# The environment. `.made` says that pip is in it, `.ready` that the package (kernels built) and what
# it needs to run are, `.ready-test` that the tools of the tests are too, and tf2_msgs beside the wheels
# of ROS, which lack it.
$(VENV)/.made: .ci/make_venv
	.ci/make_venv $(VENV) $(PYTHON)
	@touch $@

$(VENV)/.ready: $(VENV)/.made $(SETUP) $(KERNELS)
	@echo 'ros_rops: building, and installing what it needs into $(VENV) (about a minute)'
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@rm -rf build
	@touch $@

$(VENV)/.ready-test: $(VENV)/.made $(SETUP) $(KERNELS) $(OVERLAY)
	@echo 'ros_rops: building, and installing the tools of the tests into $(VENV) (three minutes)'
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@rm -rf build
	@.ci/make_overlay $(VENV)
	@touch $(VENV)/.ready $@
