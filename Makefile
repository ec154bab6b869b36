# Every target sets up what it needs in .venv by itself, again only when a lock file or pyproject.toml changes.
# Only relative paths, and nothing that make 3.81 (macOS) does not know: the folder's name may hold spaces.

PYTHON ?= $(shell command -v python3 || command -v python || echo python3)
LAB_ARGS ?=
PYTEST_ARGS ?=
PIP_ARGS ?=
BENCH_ARGS ?=
SITE_ARGS ?=
WORKERS ?= 2

PY = .venv/bin/python
# The pip of PYTHON fetches uv. Only where it cannot, .venv gets a pip of its own first, which takes some seconds.
FETCH_UV = --disable-pip-version-check $(PIP_ARGS) --quiet install --require-hashes -r .venv/uv.txt
OWN_PIP = $(PY) -m ensurepip >/dev/null && $(PY) -m pip --disable-pip-version-check
UV = $(PY) -m uv pip install --python $(PY)
# The course's matrices are small: one BLAS thread for each process is the fastest, and the same everywhere.
ONE_THREAD = OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
# The tests' modules are kept compiled, also where a machine's settings forbid it: pytest takes 10 s to rewrite them.
# tests/order.py says what runs together. nbval is for the one test that starts it.
PYTEST = PYTHONDONTWRITEBYTECODE= $(ONE_THREAD) $(PY) -m pytest -n $(WORKERS) -p no:nbval
LOCK = $(PY) -m uv --no-config pip compile pyproject.toml --universal --python-version 3.11 \
	--generate-hashes --no-strip-extras --no-emit-index-url --no-emit-find-links --no-header --annotation-style line --quiet

.DEFAULT_GOAL := help
.PHONY: help lab demo test lint test-changed test-quick test-slow test-all bench build site bundles lock clean
.NOTPARALLEL:

help:  ## say what there is
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "make %-10s %s\n", $$1, $$2}' Makefile
	@echo "Variables: PYTHON (which interpreter), LAB_ARGS, DEMO_ARGS, PYTEST_ARGS, BENCH_ARGS, SITE_ARGS, PIP_ARGS, WORKERS (test processes)"

lab: .venv/lab.stamp  ## open the lessons in JupyterLab
	$(PY) -m nao_course.cli lab $(LAB_ARGS)

demo: .venv/lab.stamp  ## let the robot drive and map the field by itself
	$(PY) -m nao_course.cli demo --out build/demo $(DEMO_ARGS)

test: lint test-quick  ## the quick tier: lint, types, all tests that are not slow

lint: .venv/dev.stamp
	@$(PY) -m ruff format --check . || { echo "Run .venv/bin/ruff format . to change these files." >&2; exit 1; }
	$(PY) -m ruff check .
	$(PY) -m mypy

test-changed: .venv/dev.stamp  ## the tests that mirror the files you have changed
	$(PYTEST) -m "not slow and not browser" $$($(PY) -m tests.changed) $(PYTEST_ARGS)

test-quick: .venv/dev.stamp
	$(PYTEST) -m "not slow and not browser" $(PYTEST_ARGS)

test-slow: .venv/dev.stamp
	$(PYTEST) -m "slow or browser" $(PYTEST_ARGS)

test-all: test test-slow  ## everything: the quick tier, then the slow tests and the browser

bench: .venv/bench.stamp  ## measure the course against its peers
	$(PY) -m benchmarks $(BENCH_ARGS)

build: .venv/dev.stamp  ## make the students' notebooks from solutions/*.md
	$(ONE_THREAD) $(PY) -m nao_course.cli build

site: .venv/site.stamp  ## make the students' pages, with SOLUTIONS=1 the instructors'; they need no other host
	$(PY) -m website $(if $(SOLUTIONS),instructor,student) $(SITE_ARGS)

bundles: web/node_modules/made.stamp  ## bundle the widgets' scripts again after a change in web/; needs node and npm
	cd web && node bundle.mjs

lock: .venv/dev.stamp  ## renew the lock files
	$(LOCK) --upgrade --extra lab --group build --output-file requirements.lock
	$(LOCK) --upgrade nao_course/instructor/pyproject.toml --no-emit-package nao-course --no-emit-package nao-course-instructor --extra lab --extra robot --extra scale --group build --group test --group dev --constraint requirements.lock --output-file requirements-dev.lock
	$(LOCK) --upgrade --extra bench --constraint requirements-dev.lock --output-file requirements-bench.lock
	$(LOCK) --upgrade --extra lab --extra hub --group build --constraint requirements-dev.lock --output-file deploy/hub/requirements.lock
	$(LOCK) --upgrade --extra site --constraint requirements-dev.lock --output-file requirements-site.lock

clean:  ## remove .venv and every cache; your notebooks stay
	rm -rf .venv web/node_modules deploy/hub/node_modules .pytest_cache .mypy_cache .ruff_cache .hypothesis .coverage htmlcov dist build/proofs build/runs.json
	find nao_course tests benchmarks solutions website -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

.venv/made.stamp:
	@$(PYTHON) -c 'import sys' 2>/dev/null || { echo "No Python found ($(PYTHON)). Install Python 3.11 or newer, or say which: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "The course needs Python 3.11 or newer; $(PYTHON) is `$(PYTHON) --version 2>&1`. Say which to use: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "$(PYTHON) cannot make virtual environments. On Debian and Ubuntu: sudo apt install python3-venv" >&2; exit 1; }
	$(PYTHON) -m venv --without-pip .venv
	@touch $@

.venv/lab.stamp: .venv/made.stamp requirements.lock pyproject.toml
	@echo "Setting up .venv for the lessons; the first time this downloads some 200 MB."
	$(call install,requirements.lock)
	@touch $@

# The big lock holds all of the small one, in the same versions.
.venv/dev.stamp: .venv/made.stamp requirements-dev.lock pyproject.toml
	@echo "Setting up .venv for tests and instructors; the first time this downloads some 340 MB."
	$(call install,requirements-dev.lock,--compile-bytecode)
	@touch .venv/lab.stamp $@

# The peers that the course is measured beside, on top of the big lock.
.venv/bench.stamp: .venv/dev.stamp requirements-bench.lock
	$(call install,requirements-bench.lock,--compile-bytecode)
	@touch $@

# JupyterHub, for its tests and its load test; the proxy comes from npm.
.venv/hub.stamp: .venv/dev.stamp deploy/hub/requirements.lock deploy/hub/package-lock.json
	$(call install,deploy/hub/requirements.lock,--compile-bytecode)
	cd deploy/hub && npm ci --ignore-scripts --no-fund --no-audit
	@touch $@

# What makes pages of the lessons, on top of the big lock.
.venv/site.stamp: .venv/dev.stamp requirements-site.lock
	$(call install,requirements-site.lock,--compile-bytecode)
	@touch $@

# The bundler, and the libraries that go into the bundles.
web/node_modules/made.stamp: web/package-lock.json
	cd web && npm ci --ignore-scripts --no-fund --no-audit
	@touch $@

# uv does in seconds what takes pip minutes; where uv cannot be had or fails, pip does it, as slowly as ever. A student's
# packages are compiled when they are first imported: compiling all of them takes longer than all the rest.
define install
@$(PY) -m uv --version >/dev/null 2>&1 || { sed -n '/^uv==/,/[^\\]$$/p' requirements.lock >.venv/uv.txt; \
	$(PYTHON) -m pip --python .venv $(FETCH_UV) 2>/dev/null || $(PYTHON) -m pip --version >/dev/null 2>&1 || { $(OWN_PIP) $(FETCH_UV); } || true; }
@$(UV) $(2) --require-hashes -r $(1) || { $(OWN_PIP) $(PIP_ARGS) install --require-hashes -r $(1); } || { echo "Setting up .venv from $(1) failed (see above). Is this computer online, with 2 GB free? The same command goes on from here." >&2; exit 1; }
@$(UV) --quiet --no-deps --no-build-isolation -e . || { $(OWN_PIP) $(PIP_ARGS) --quiet install --no-deps --no-build-isolation -e .; }
endef
