# All chores of the project: make play | check | test | bench | lint | format.
#
# Needs make and Python >= 3.11 (with venv); tests and lint also need Node.js >= 20.19 (with npm). On
# Debian, as root or with sudo, apt installs what is missing. Everything else goes into .venv and
# node_modules. Each step of the environment leaves a stamp file there, so that it runs again only after
# a change of its inputs.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV ?= .venv
HOST ?= 127.0.0.1
PORT ?= 8000
# May exceed the number of cores: many tests wait for falling balls.
PYTEST_WORKERS ?= 4
PYTEST_ARGS ?=
AFTER ?=
BENCH_ARGS ?= --record
KILLS ?= 50
FAULTS ?= 20
HOURS ?= 2

BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
PINS := pyproject.toml constraints.txt
# The extras of a complete server (`certify` is python-flint, for proofs), and all extras.
SERVER := server,certify
ALL := $(SERVER),postgres,redis,batches,table,video
WITH_NODE := node="$$(tools/node)" && export PATH="$$node:$$PATH"
NPM_INSTALL := npm install --no-audit --no-fund --no-package-lock --ignore-scripts --loglevel=error

.PHONY: help play check test test-servers test-long test-crash test-attack test-browsers test-arm64 lint docs site links format bench readme architecture size pictures constraints clean kernels npm

help:
	@echo 'make play         start the server and print its address (PORT=8000)'
	@echo 'make check        run the tests that need only Python (two minutes)'
	@echo 'make test         run all tests but those of test-servers, in a browser too (six minutes)'
	@echo 'make test-servers run the tests of ledgers, clusters, relays and proxies (two minutes)'
	@echo 'make test-long    run the tests marked "long": sieges, measurements, many more cases'
	@echo 'make test-crash   kill and stall a server under load, on both databases (KILLS=50 FAULTS=20)'
	@echo 'make test-attack  attack, kill and stall a server for hours (HOURS=2); takes half a core'
	@echo 'make test-browsers compare digests in Firefox, WebKit, Chromium, Node.js and wasmtime'
	@echo 'make test-arm64   compare the golden digests on an emulated arm64 processor (minutes)'
	@echo 'make lint         check style, format, types and import contracts'
	@echo 'make docs         build the documentation in build/site; fails at any warning'
	@echo 'make site         build the documentation and the game without a server in build/site, for any web host'
	@echo 'make links        check the links of the documentation to other sites (needs the network)'
	@echo 'make format       format the code'
	@echo 'make bench        measure speed and error; updates docs/measured and the README'
	@echo 'make readme       run the examples in the pages and update their output'
	@echo 'make architecture draw the packages and their permitted imports'
	@echo 'make size         print lines, files, classes and functions of product and tests'
	@echo 'make pictures     update the pictures of the documentation'
	@echo 'make kernels      compile changed kernels to WebAssembly and native code (six minutes)'
	@echo 'make constraints  pin the newest versions that work together'
	@echo 'make npm          make the npm package of the page'"'"'s solver in build/npm'
	@echo 'make clean        remove the environment and all caches'

play: $(VENV)/.stamp-play
	exec $(BIN)/plinko serve --host $(HOST) --port $(PORT)

# Tests that need only Python: physics, rules, protocol and pictures. No other program is in their PATH.
CHECKED ?= tests/engine tests/outsider tests/app/computing tests/app/fairness \
	tests/app/ops tests/app/protocol tests/app/render tests/app/rooms

check: export PYTHONDONTWRITEBYTECODE =
check: $(VENV)/.stamp-test
	PATH=$(abspath $(BIN)) $(BIN)/python -m pytest -n auto --dist worksteal -m 'not postgresql and not long' $(CHECKED) \
		$(PYTEST_ARGS)

# Tests of durability and of several servers: failing and frozen ledgers, killed servers, clusters, relays
# and proxies.
SERVERS ?= tests/app/cluster tests/app/persistence tests/app/relay tests/deploy

# Node.js tests the pages' pure modules; other tests drive a real Chromium.
# No test depends on the machine's speed: `tools/busy make test` runs them under load.
# The tests start a hundred servers and commands. PYTHONDONTWRITEBYTECODE is cleared, so that Python
# compiles the modules only once. `make test AFTER=check` leaves out what `make check` has run.
test: export PYTHONDONTWRITEBYTECODE =
test: AFTER_CHECK := $(if $(filter check,$(AFTER)),--checked '$(CHECKED)')
test: $(VENV)/.stamp-test node_modules/.stamp
	$(WITH_NODE) && chromium="$$(tools/chromium shell)" && \
	CHROMIUM="$$chromium" $(BIN)/python -m pytest -n $(PYTEST_WORKERS) --dist worksteal \
		$(SERVERS:%=--ignore %) $(AFTER_CHECK) $(PYTEST_ARGS)

# They start PostgreSQL, Redis and proxies, installed from Debian if necessary.
test-servers: export PYTHONDONTWRITEBYTECODE =
test-servers: $(VENV)/.stamp-test
	tools/postgresql
	tools/proxies
	tools/redis
	$(BIN)/python -m pytest -n $(PYTEST_WORKERS) --dist worksteal $(SERVERS) $(PYTEST_ARGS)

# On SQLite and on PostgreSQL, a server under load is killed KILLS times, and gets FAULTS stalls, frozen
# backends, broken connections and full disks, of each kind. Every step of a commit fails once.
test-crash: $(VENV)/.stamp-test
	tools/postgresql
	LONG=1 PLINKO_TEST_KILLS=$(KILLS) PLINKO_TEST_FAULTS=$(FAULTS) $(BIN)/python -m pytest -s -m long tests/app/persistence

# On SQLite, with the attackers of `python -m benchmarks attack`. In the end every ball is accounted for.
test-attack: $(VENV)/.stamp-test
	LONG=1 PLINKO_TEST_HOURS=$(HOURS) $(BIN)/python -m pytest -s -m long tests/app/persistence/crash/test_crash_attack.py

# Tests that run only with LONG=1, or try more cases then, have the marker `long` (tests/long.py): sieges,
# killed and frozen servers, a soak of ten minutes, benchmarks, 10^5 malformed messages, hundreds of
# requests of each REST operation, every oracle file, axe on every screen.
test-long: $(VENV)/.stamp-test node_modules/.stamp
	tools/postgresql
	tools/proxies
	tools/redis
	$(WITH_NODE) && chromium="$$(tools/chromium shell)" && CHROMIUM="$$chromium" \
	LONG=1 PLINKO_TEST_KILLS=$(KILLS) PLINKO_TEST_FAULTS=$(FAULTS) $(BIN)/python -m pytest -s -m long $(PYTEST_ARGS)

# The page's solver in every JavaScript engine: all presets with 500 seeds, 200 random boards with 20.
test-browsers: $(VENV)/.stamp-test
	firefox="$$(tools/firefox)" && jsc="$$(tools/jsc)" && chromium="$$(tools/chromium shell)" && \
	LONG=1 FIREFOX="$$firefox" JSC="$$jsc" CHROMIUM="$$chromium" $(BIN)/python -m pytest \
		tests/js/solver/test_engines.py \
		tests/js/solver/test_solver.py::test_a_page_computes_every_drop_to_the_engine_s_last_bit

# Unpacks Debian packages and wheels for arm64 into .arm64, and runs their Python and wasmtime in QEMU.
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

# The pages and the tutorial, which is executed. Internal links are checked.
docs: $(VENV)/.stamp-docs
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet $(SPHINX_ARGS) -d .cache/doctrees docs build/site
	@echo 'build/site/index.html'

# The pages, of which the first then shows the game in the folder play/.
site: SPHINX_ARGS := -t game
site: docs
	$(BIN)/plinko site build/site/play
	touch build/site/.nojekyll

links: $(VENV)/.stamp-docs
	$(BIN)/python -m sphinx -b linkcheck --quiet -D nb_execution_mode=off -d .cache/doctrees docs build/links

# Makes every table and plot in docs/measured, and updates the README. BENCH_ARGS=--quick
# only tries it.
bench: $(VENV)/.stamp-bench
	tools/postgresql
	tools/redis
	$(WITH_NODE) && chromium="$$(tools/chromium)" && \
	CHROMIUM="$$chromium" $(BIN)/python -m benchmarks all $(BENCH_ARGS)

format: $(VENV)/.stamp-lint
	$(BIN)/ruff check --fix-only --quiet .
	$(BIN)/ruff format .

# Updates the output and pictures of the examples in the README and docs/pictures.md.
readme: $(VENV)/.stamp-test
	$(BIN)/python -m tools.board_form
	CHROMIUM="$$(tools/chromium)" $(BIN)/python -m tools.readme

# Draws docs/images/architecture.svg from the import contract.
architecture: $(VENV)/.stamp-test
	$(BIN)/python -m tools.architecture

# Takes new screenshots of the pages, and updates docs/pictures.md, which takes a million drops.
pictures: $(VENV)/.stamp-test
	CHROMIUM="$$(tools/chromium)" $(BIN)/python -m tools.photographs
	$(BIN)/python -m tools.readme docs/pictures.md

# Writes engine/artifact/*.wasm and native/*, static/js/solver/kernels.wasm and
# app/render/raster/pixels.wasm. A test fails when they are stale.
kernels: $(VENV)/.stamp-kernels
	$(BIN)/python -m plinko.engine.artifact.make
	$(BIN)/python -m plinko.app.render.raster.make
	$(BIN)/python -m benchmarks.billiards.make

# Installs the newest versions that the ranges in pyproject.toml allow together, and pins them.
constraints:
	rm -rf .cache/constraints
	mkdir -p .cache
	tools/make-venv $(PYTHON) .cache/constraints
	.cache/constraints/bin/python -m pip --quiet install --upgrade pip
	.cache/constraints/bin/python -m pip --quiet install '.[$(ALL)]' --group lint --group docs --group kernels
	{ head -n 1 constraints.txt; \
	  .cache/constraints/bin/python -m pip freeze --all --exclude plinko-sim --exclude setuptools; } > .cache/constraints.txt
	mv .cache/constraints.txt constraints.txt
	rm -rf .cache/constraints

# The page's solver for other pages and Node.js, ready for `npm publish`.
npm: $(VENV)/.stamp-play node_modules/.stamp
	$(WITH_NODE) && tools/npm-package build/npm $(BIN)/python

size:
	@$(PYTHON) tools/size.py

clean:
	rm -rf $(VENV) .cache .hypothesis .mypy_cache .pytest_cache .ruff_cache .import_linter_cache
	rm -rf artifacts build dist node_modules benchmarks/node/node_modules
	find . -name __pycache__ -not -path './.git/*' -prune -exec rm -rf {} +

$(VENV)/.stamp-play: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(SERVER)]'
	touch $@

$(VENV)/.stamp-test: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL)]' --group test
	touch $@ $(VENV)/.stamp-play

$(VENV)/.stamp-lint: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL)]' --group lint
	touch $@ $(VENV)/.stamp-test $(VENV)/.stamp-play

$(VENV)/.stamp-kernels: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL)]' --group test --group kernels
	touch $@ $(VENV)/.stamp-test $(VENV)/.stamp-play

$(VENV)/.stamp-docs: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(SERVER)]' --group docs
	touch $@ $(VENV)/.stamp-play

$(VENV)/.stamp-bench: $(PINS) | $(VENV)/.stamp-venv
	$(PIP) install -c constraints.txt -e '.[$(ALL)]' --group bench
	touch $@ $(VENV)/.stamp-play

$(VENV)/.stamp-venv: tools/make-venv constraints.txt
	tools/make-venv $(PYTHON) $(VENV)
	touch $@

# JavaScript physics engines that benchmarks and tests compare with.
test test-long bench: benchmarks/node/node_modules/.stamp

benchmarks/node/node_modules/.stamp: benchmarks/node/package.json
	$(WITH_NODE) && cd benchmarks/node && $(NPM_INSTALL)
	touch $@

# Tools that check the pages' scripts. The scripts themselves need no build.
node_modules/.stamp: package.json
	$(WITH_NODE) && $(NPM_INSTALL)
	touch $@
