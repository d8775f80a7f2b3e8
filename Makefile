# make demo: the paper's case study, from task files to certified C.   make test: everything that must hold.
# make integration: what is too heavy for make test, run before a change is called done (about three hours on two cores; what is green is not run again).
# Both set up what they need: Python packages in .venv from the hashed lock, system packages through apt when root.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
PEERS := $(VENV)/.peers
PHYSICS := $(VENV)/.physics
INTEGERS := $(sort $(shell grep -l '^scalar = "fixed"' tasks/*.toml))
TASKS := $(filter-out $(INTEGERS),$(sort $(wildcard tasks/*.toml)))
CASE_STUDY := tasks/omni_s1.toml tasks/omni_s2.toml tasks/omni_s3.toml

.PHONY: demo test integration generate check checker peers policies physics ros ends lock clean help

help:
	@sed -n 's/^# //p' Makefile | head -3

demo: $(STAMP)
	@.ci/tools demo
	@$(BIN)/stt-codegen generate $(CASE_STUDY) --out demo
	@for task in $(CASE_STUDY); do $(BIN)/stt-codegen design $$task --picture demo || exit; done
	@for task in $(CASE_STUDY); do $(BIN)/stt-codegen compare $$task || exit; done
	@for task in $(CASE_STUDY); do $(BIN)/stt-codegen simulate $$task --gain best --disturbance nearest --w-max 0.3 --out demo || exit; done
	@$(BIN)/stt-codegen report tasks/omni_s2.toml --out demo/omni_s2.report.html
	@echo "Open demo/omni_s2.report.html. Look at demo/: pictures (.png), C (.h, .c), Python (.py), certificates (.certificate.json), traces (.loop.csv)."

test: $(STAMP) $(if $(CI),$(PEERS) $(PHYSICS))
	@.ci/tools test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/pytest -n auto --dist loadgroup -m "not slow"

# Each job fails where a law is broken; benchmarks/integration.py lists them and remembers which are green. OPTIONS="--list" shows them.
integration: $(STAMP) $(PHYSICS) $(if $(CI),$(PEERS) build/ros/.done)
	@.ci/tools test
	@.ci/tools integration
	@$(BIN)/python -m benchmarks integration $(OPTIONS)

# Everything in generated/: refined from every task file, in both precisions, or in integers alone; the case study with the paper's functions, sound
# (adaptive, certified) and as the paper has it (literal, which collides and says so).
generate: $(STAMP)
	@for scalar in float double; do $(BIN)/stt-codegen generate $(TASKS) --record generated --scalar $$scalar || exit; done
	@$(BIN)/stt-codegen generate $(INTEGERS) --record generated
	@$(BIN)/stt-codegen generate $(CASE_STUDY) --record generated --design adaptive
	@$(BIN)/stt-codegen generate $(CASE_STUDY) --record generated --design literal --uncertified
	@for task in $(TASKS); do name=$$(basename $$task .toml); \
	    $(BIN)/stt-codegen prove $$task --out generated/$$name/refined/float >/dev/null || [ $$? = 1 ] || exit; done # 1: not all is proved, as of watchman's tick
	@for task in $(INTEGERS); do name=$$(basename $$task .toml); \
	    $(BIN)/stt-codegen prove $$task --out generated/$$name/refined/fixed >/dev/null || [ $$? = 1 ] || exit; done
	@$(BIN)/stt-codegen prove

check: $(STAMP)
	@$(BIN)/stt-codegen check generated

# The stand-alone checker as one file, dist/checker.pyz: the same bytes on every machine. It needs Python 3.11 and nothing else.
checker: $(STAMP)
	@mkdir -p dist
	@$(BIN)/python -m stt_codegen.checker.archive dist/checker.pyz && echo "checker: dist/checker.pyz"

$(STAMP): locks/requirements.lock pyproject.toml
	@.ci/tools python
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python .ci/install locks/requirements.lock
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

# What the arenas benchmark compares with (planners, reachability, a solver); its tests are skipped where it is missing.
peers: $(PEERS)

$(PEERS): locks/peers.lock $(STAMP)
	@$(BIN)/python .ci/install locks/peers.lock
	@touch $@

# The policies of the reinforcement learning peer, in an environment of their own: about 70 minutes on one core. Weights are not in the
# repository; without them the rows of `python -m benchmarks arenas --peers` and `python -m benchmarks loop --peers` on policies are left out.
policies: $(STAMP)
	@test -x build/rl/bin/python || $(PYTHON) -m venv build/rl
	@build/rl/bin/python .ci/install locks/peers-rl.lock
	@PYTHONPATH=. OMP_NUM_THREADS=1 build/rl/bin/python -m benchmarks policy --out build/policies

# MuJoCo, for benchmarks/physics.py; its test is skipped where it is missing.
physics: $(PHYSICS)

$(PHYSICS): locks/physics.lock $(STAMP)
	@$(BIN)/python .ci/install locks/physics.lock
	@touch $@

# ROS 2's Python client as wheels, in an environment of its own (270 MB): the node is tried in it by the slow tests and benchmarks/ros.py.
ros: build/ros/.done

build/ros/.done: locks/ros.lock $(STAMP)
	@test -x build/ros/bin/python || $(PYTHON) -m venv build/ros
	@build/ros/bin/python .ci/install locks/ros.lock
	@touch $@

# The oldest versions that pyproject.toml admits, then the newest, installed apart: generated/ comes out the same, and demo and --json work.
ends: $(STAMP)
	@$(BIN)/python -m benchmarks ends

# After changing a version in pyproject.toml (needs uv): pins and hashes, without naming a registry.
lock:
	uv pip compile --universal --generate-hashes --no-header --no-annotate --extra test pyproject.toml -o locks/requirements.lock
	uv pip compile --universal --generate-hashes --no-header --no-annotate --extra test --extra peers -c locks/requirements.lock pyproject.toml -o locks/peers.lock
	uv pip compile --universal --generate-hashes --no-header --no-annotate --extra peers-rl pyproject.toml -o locks/peers-rl.lock
	uv pip compile --universal --generate-hashes --no-header --no-annotate --extra ros pyproject.toml -o locks/ros.lock
	uv pip compile --universal --generate-hashes --no-header --no-annotate --extra test --extra physics -c locks/requirements.lock pyproject.toml -o locks/physics.lock

clean:
	rm -rf $(VENV) demo dist build .mypy_cache .ruff_cache .pytest_cache .hypothesis
