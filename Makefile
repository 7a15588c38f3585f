# The commands of the repository. `make help` lists them. Everything is installed and built by packaging/setup.sh.
SHELL := /bin/bash
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL:
.PHONY: help setup daemon demo extension test test-gui sanitize fuzz chaos foldings lint format docs site bench gallery projects atlas clean

PYTHON := .venv/bin/python
JOBS ?= $(shell nproc)
# One Python worker per two threads of the daemons they start, at most 4.
WORKERS ?= $(shell n=$$(nproc); echo $$(( n > 4 ? 4 : n )))

help:  ## list the commands
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## */make \1\t/' | expand -t 16

setup:  ## install what is missing, build the daemon
	@bash packaging/setup.sh

daemon:  ## build the daemon and its tests
	@bash packaging/setup.sh --tests

demo: setup  ## solve and render the bundled Z-plasty into build/demo
	@.venv/bin/lappet demo -o build/demo

extension: setup  ## make the zip that Blender installs into dist/
	@$(PYTHON) packaging/extension.py

test:  ## run every test: the daemon's (ctest), then Python's (pytest)
	@bash packaging/setup.sh --tests
	@status=0; \
	ctest --test-dir build --output-on-failure --no-tests=error --parallel $(JOBS) || status=1; \
	$(PYTHON) -m pytest -q -n $(WORKERS) --dist loadfile --no-loadscope-reorder --durations=10 || status=1; \
	exit $$status

test-gui: setup  ## drive a real Blender window (makes a Debian sid with one first: root, 1.5 GB)
	@$(PYTHON) tests/gui/run.py

sanitize:  ## run the daemon's tests, 100 000 mutated messages and several clients under sanitizers
	@bash packaging/sanitize.sh

fuzz:  ## play MESSAGES (1 000 000) mutated messages of a SEED (1) under sanitizers; what fails goes to build/findings
	@SEED=$(or $(SEED),1) bash packaging/sanitize.sh --messages $(or $(MESSAGES),1000000)

foldings:  ## fold COUNT (500) flaps at random by SEED (1) with self-contact; another library looks whether tissue passes through tissue
	@status=0; $(PYTHON) tests/foldings.py --count $(or $(COUNT),500) --seed $(or $(SEED),1) \
		--result docs/robustness_foldings.json || status=$$?; $(PYTHON) packaging/documents.py --write >/dev/null; exit $$status

chaos:  ## solve for two minutes while it is killed, stopped, interrupted, filled, cut and pruned, at random by SEED (1)
	@status=0; $(PYTHON) tests/chaos.py --seconds 120 --seed $(or $(SEED),1) --result docs/robustness_chaos.json || status=$$?; \
	$(PYTHON) packaging/documents.py --write >/dev/null; exit $$status  # docs/robustness.md shows it

lint:  ## check style, types, import directions, docstrings, documents and known vulnerabilities
	@bash packaging/lint.sh

format:  ## rewrite sources in the house style
	@$(PYTHON) -m ruff check --fix --quiet . || true
	@$(PYTHON) -m ruff format --quiet .
	@find solverd -name '*.h' -o -name '*.cpp' | xargs -r .venv/bin/clang-format -i

docs:  ## write docs/command_line.md from the program and check the links of every Markdown file
	@$(PYTHON) packaging/documents.py --write

site:  ## build the documents and the API reference as a site into build/site
	@$(PYTHON) packaging/build_site.py

bench:  ## measure kernels, scenes, sheets and stages into build/bench (PARTS=pipeline; FINE=1: up to a million cells)
	@bash packaging/setup.sh --benchmarks
	@$(PYTHON) -m lappet.bench $(PARTS) -o build/bench $(if $(FINE),--fine)

gallery: setup  ## draw the plates of docs/gallery into it (about 20 minutes of solving on two cores)
	@$(PYTHON) packaging/gallery.py

projects: setup  ## write a Blender file for each page of the gallery into build/gallery/blends; nothing is solved
	@$(PYTHON) packaging/gallery_blends.py build/gallery/blends

atlas: setup  ## solve and draw every design of the flap library into build/atlas; docs/flaps.md shows it
	@$(PYTHON) -m lappet report atlas -o build/atlas
	@$(PYTHON) packaging/flap_pictures.py build/atlas
	@$(PYTHON) packaging/documents.py --write >/dev/null

clean:  ## remove what was built, solved and rendered; .venv stays
	@rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find shared addon tests packaging examples -name __pycache__ -type d -prune -exec rm -rf {} +
