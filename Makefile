# The chores, one obvious way each: make play | check | test | bench | lint | format.
#
# Needs make and Python >= 3.11 (with venv), for tests and lint Node.js >= 20.19 (with npm) too; on
# Debian, as root or with sudo, missing ones are installed by apt. Everything else goes into .venv and
# node_modules. Each environment step leaves a stamp file there, so that it runs again only when what
# it was made from changed.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV ?= .venv
HOST ?= 127.0.0.1
PORT ?= 8000
# One more than cores: many tests wait for balls that fall.
PYTEST_WORKERS ?= 4
PYTEST_ARGS ?=
BENCH_ARGS ?= --record
KILLS ?= 50
FAULTS ?= 20
HOURS ?= 2

BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
PINS := pyproject.toml constraints.txt
# What a server has with all its parts: `certify` is python-flint, for proofs.
ALL := server,certify
WITH_NODE := node="$$(tools/node)" && export PATH="$$node:$$PATH"
NPM_INSTALL := npm install --no-audit --no-fund --no-package-lock --ignore-scripts --loglevel=error

.PHONY: help play check test test-servers test-long test-crash test-attack test-browsers test-arm64 lint docs links format bench readme architecture pictures constraints clean kernels npm

help:
	@echo 'make play         start the server and print its address (PORT=8000)'
	@echo 'make check        run the tests of CHECKED, which need only Python (a minute)'
	@echo 'make test         run the tests, browser tests included (five minutes)'
	@echo 'make test-servers run the tests of SERVERS: kept, shared and lost, over SQLite and PostgreSQL (two)'
	@echo 'make test-long    run the tests marked "long": sieges, measurements, many more tries'
	@echo 'make test-crash   of these, a server under load killed, stalled, cut off, full (KILLS=50 FAULTS=20)'
	@echo 'make test-attack  a server attacked, killed and stalled for long (HOURS=2), at half a core'
	@echo 'make test-browsers compare digests in Firefox, WebKit, Chromium, Node.js and wasmtime'
	@echo 'make test-arm64   compare the golden digests on an emulated arm64 processor (minutes)'
	@echo 'make lint         style, format, types and import contracts'
	@echo 'make docs         make the site of these pages in build/site; a warning fails'
	@echo 'make links        ask every other site that the pages link to (needs the network)'
	@echo 'make format       put the code in its format'
	@echo 'make bench        measure speed and error, for docs/measured, the pages and the README'
	@echo 'make readme       run the examples of the pages and write what they print'
	@echo 'make architecture draw the packages and what they may import'
	@echo 'make pictures     take and draw the pictures of the documentation anew'
	@echo 'make kernels      compile the kernels, to WebAssembly and native code, when one changed (six minutes)'
	@echo 'make constraints  pin the newest versions that work together'
	@echo 'make npm          make the npm package of the page'"'"'s solver in build/npm'
	@echo 'make clean        remove the environment and all caches'

play: $(VENV)/.stamp-play
	exec $(BIN)/plinko serve --host $(HOST) --port $(PORT)

# What needs no server, no browser and nothing of Debian: physics, rules, protocol and pictures.
CHECKED ?= tests/engine tests/outsider tests/app/computing tests/app/conformance tests/app/fairness \
	tests/app/ops tests/app/protocol tests/app/render tests/app/rooms

check: export PYTHONDONTWRITEBYTECODE =
check: $(VENV)/.stamp-test
	$(BIN)/python -m pytest -n auto --dist worksteal -m 'not postgresql and not long' $(CHECKED) \
		$(PYTEST_ARGS)

# What servers keep and lose: ledgers that fail, are cut off or freeze, servers that are killed, several
# as one, relays, proxies.
SERVERS ?= tests/app/cluster tests/app/persistence tests/app/relay tests/deploy

# The page's pure modules run in Node.js. Other tests drive a real Chromium.
# No result depends on how fast the machine is: `tools/busy make test` runs them beside busy loops.
# A hundred servers and commands start: whatever the environment says, they are compiled once.
test: export PYTHONDONTWRITEBYTECODE =
test: $(VENV)/.stamp-test node_modules/.stamp
	$(WITH_NODE) && node --test --test-reporter=spec $$(find tests/js -name '*.test.js' | sort)
	chromium="$$(tools/chromium shell)" && \
	CHROMIUM="$$chromium" $(BIN)/python -m pytest -n $(PYTEST_WORKERS) --dist worksteal \
		$(SERVERS:%=--ignore %) $(PYTEST_ARGS)

# They start PostgreSQL, Redis and proxies: the machine's own, or else Debian's.
test-servers: export PYTHONDONTWRITEBYTECODE =
test-servers: $(VENV)/.stamp-test
	tools/postgresql
	tools/proxies
	tools/redis
	$(BIN)/python -m pytest -n $(PYTEST_WORKERS) --dist worksteal $(SERVERS) $(PYTEST_ARGS)

# Under load, over SQLite and over PostgreSQL, the server is killed KILLS times and meets FAULTS
# stalls, frozen backends, cut lines and full disks, of each kind; and every step of a commit fails.
test-crash: $(VENV)/.stamp-test
	tools/postgresql
	LONG=1 PLINKO_TEST_KILLS=$(KILLS) PLINKO_TEST_FAULTS=$(FAULTS) $(BIN)/python -m pytest -s -m long tests/app/persistence

# Over SQLite, by the attackers of `python -m benchmarks attack`; then every ball is accounted for.
test-attack: $(VENV)/.stamp-test
	LONG=1 PLINKO_TEST_HOURS=$(HOURS) $(BIN)/python -m pytest -s -m long tests/app/persistence/crash/test_crash_attack.py

# Each test that tries more with LONG=1, or runs only then, has the marker `long`, see tests/long.py:
# sieges, servers killed and frozen, ten minutes of soak, benchmarks, 10^5 malformed messages, hundreds
# of requests of each REST operation, every oracle file, axe on every screen.
test-long: $(VENV)/.stamp-test node_modules/.stamp
	tools/postgresql
	tools/proxies
	tools/redis
	$(WITH_NODE) && chromium="$$(tools/chromium shell)" && CHROMIUM="$$chromium" \
	LONG=1 PLINKO_TEST_KILLS=$(KILLS) PLINKO_TEST_FAULTS=$(FAULTS) $(BIN)/python -m pytest -s -m long $(PYTEST_ARGS)

# The page's solver in every engine: all presets with 500 seeds, 200 random boards with 20.
test-browsers: $(VENV)/.stamp-test
	firefox="$$(tools/firefox)" && jsc="$$(tools/jsc)" && chromium="$$(tools/chromium shell)" && \
	LONG=1 FIREFOX="$$firefox" JSC="$$jsc" CHROMIUM="$$chromium" $(BIN)/python -m pytest \
		tests/js/solver/test_engines.py \
		tests/js/solver/test_solver.py::test_a_page_computes_every_drop_to_the_engine_s_last_bit \
		tests/engine/artifact/test_artifact.py::test_the_page_s_artifact_gives_the_engine_s_bits

# Debian packages and wheels for arm64, unpacked into .arm64 and run by QEMU: wasmtime there, and Python.
test-arm64: $(VENV)/.stamp-play
	tests/arm64/check $(BIN)/python

lint: $(VENV)/.stamp-lint node_modules/.stamp
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.dependabot .github/dependabot.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/bug.yml .github/ISSUE_TEMPLATE/idea.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff
	$(BIN)/check-jsonschema --builtin-schema vendor.compose-spec deploy/compose.yaml
	$(WITH_NODE) && node_modules/.bin/eslint .
	$(WITH_NODE) && node_modules/.bin/tsc

# Of the pages, docstrings and the tutorial, which is run. Links within are checked, all warnings fail.
docs: $(VENV)/.stamp-docs
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet -d .cache/doctrees docs build/site
	@echo 'build/site/index.html'

links: $(VENV)/.stamp-docs
	$(BIN)/python -m sphinx -b linkcheck --quiet -D nb_execution_mode=off -d .cache/doctrees docs build/links

# Every table and plot of docs/measured, and the pages that show them; BENCH_ARGS=--quick for a trial.
bench: $(VENV)/.stamp-bench
	tools/postgresql
	tools/redis
	$(WITH_NODE) && chromium="$$(tools/chromium)" && \
	CHROMIUM="$$chromium" $(BIN)/python -m benchmarks all $(BENCH_ARGS)

format: $(VENV)/.stamp-lint
	$(BIN)/ruff check --fix-only --quiet .
	$(BIN)/ruff format .

# What the examples of the README and of docs/pictures.md print, and their pictures, anew.
readme: $(VENV)/.stamp-test
	$(BIN)/python -m tests.repository.reference
	CHROMIUM="$$(tools/chromium)" $(BIN)/python -m tests.repository.readme

# The drawing of the packages, from the import contract.
architecture: $(VENV)/.stamp-test
	$(BIN)/python -m tests.repository.architecture

# Screenshots of the pages, and docs/pictures.md, which takes a million drops, anew.
pictures: $(VENV)/.stamp-test
	CHROMIUM="$$(tools/chromium)" $(BIN)/python -m tests.repository.photographs
	$(BIN)/python -m tests.repository.readme docs/pictures.md

# engine/artifact/*.wasm and native/*, the page's static/js/solver/kernels.wasm and
# app/render/raster/pixels.wasm; a test says when they are stale.
kernels: $(VENV)/.stamp-kernels
	$(BIN)/python -m engine.artifact.make
	$(BIN)/python -m app.render.raster.make
	$(BIN)/python -m benchmarks.billiards.make

# The newest versions that the ranges in pyproject.toml allow, tried and written down together.
constraints:
	rm -rf .cache/constraints
	mkdir -p .cache
	tools/make-venv $(PYTHON) .cache/constraints
	.cache/constraints/bin/python -m pip --quiet install '.[$(ALL),test,lint,bench,docs,kernels]'
	{ head -n 1 constraints.txt; \
	  .cache/constraints/bin/python -m pip freeze --exclude plinko-server; } > .cache/constraints.txt
	mv .cache/constraints.txt constraints.txt
	rm -rf .cache/constraints

# The page's solver for others' pages and Node.js, ready for `npm publish`.
npm: node_modules/.stamp
	$(WITH_NODE) && tools/npm-package build/npm

clean:
	rm -rf $(VENV) .cache .hypothesis .mypy_cache .pytest_cache .ruff_cache .import_linter_cache
	rm -rf artifacts build dist node_modules benchmarks/node/node_modules
	find . -name __pycache__ -not -path './.git/*' -prune -exec rm -rf {} +

$(VENV)/.stamp-play: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL)]'
	touch $@

$(VENV)/.stamp-test: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL),test]'
	touch $@ $(VENV)/.stamp-play

# The types of the tests' own libraries are checked too, hence both extras.
$(VENV)/.stamp-lint: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL),test,lint]'
	touch $@ $(VENV)/.stamp-test $(VENV)/.stamp-play

$(VENV)/.stamp-kernels: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL),test,kernels]'
	touch $@ $(VENV)/.stamp-test $(VENV)/.stamp-play

$(VENV)/.stamp-docs: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL),docs]'
	touch $@ $(VENV)/.stamp-play

$(VENV)/.stamp-bench: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL),bench]'
	touch $@ $(VENV)/.stamp-play

$(VENV)/.stamp-venv: tools/make-venv
	tools/make-venv $(PYTHON) $(VENV)
	touch $@

# Engines for Node.js that the benchmarks compare with, and the tests see play.
test test-long bench: benchmarks/node/node_modules/.stamp

benchmarks/node/node_modules/.stamp: benchmarks/node/package.json
	$(WITH_NODE) && cd benchmarks/node && $(NPM_INSTALL)
	touch $@

# What checks the page's scripts, which are themselves served as they lie in static/.
node_modules/.stamp: package.json
	$(WITH_NODE) && $(NPM_INSTALL)
	touch $@
