# `make first`: a first table within minutes; `make tables`: all of them; `make test`; and `make check`, which runs every
# rule once, in minutes. Each first makes the virtual environment that it needs.
# PYTHON: the interpreter the environment is made with; CORES: jobs at a time.

PYTHON ?= python3
CORES ?= 2
PIP := pip install --disable-pip-version-check
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
export PATH := $(CURDIR)/.venv/bin:$(PATH)

.PHONY: first tables photographs test browser cluster lint check endurance

# Its episodes are the same as those of `make tables`, which finds them there.
first: .venv/installed
	snakemake -j$(CORES) tables report --configfile workflows/config/ci.yaml workflows/config/overlays/first.yaml

tables: .venv/installed
	snakemake -j$(CORES) tables

# From a folder of photographs, or a video, to its tables: make photographs FROM=DIR. Their poses are found once, and kept
# with the pictures in captures/<name of FROM>; that photographs are others than those is noticed. The name is that of the
# folder itself, whatever links and dots FROM has; of a video, it is that without the suffix. In quotation marks it stays
# one text for Snakemake, whatever its characters mean in YAML; the blanks keep Snakemake from taking the marks away.
export FROM

photographs: .venv/installed
	@fail() { echo "error: FROM=$$FROM: $$1; say make photographs FROM=DIR" >&2; exit 2; }; \
	test -n "$$FROM" || fail "names no folder of photographs"; \
	place=$$(realpath -e -- "$$FROM" 2> /dev/null) || fail "there is no such folder or video"; \
	root=$${place%/}/; case "$(CURDIR)/" in "$$root"*) fail "holds this project, whose own pictures would count";; esac; \
	name=$${place##*/}; test -d "$$place" || name=$${name%.*}; \
	test -n "$$name" || fail "has no name that a capture could take"; \
	capture="captures/$$name"; quote="'"; \
	python -m avs data pose --out "$$capture" -- "$$place"; \
	snakemake -j$(CORES) tables \
	    --configfile workflows/config/small.yaml workflows/config/overlays/photographs.yaml \
	    --config scenes_dir=" '$${capture//$$quote/$$quote$$quote}' " \
	    || { status=$$?; echo "To go on: make photographs FROM='$$FROM'; what is there is kept." >&2; exit $$status; }

check: .venv/installed
	snakemake -j$(CORES) tables figures --configfile workflows/config/check.yaml

# A file's tests stay together: what many of them begin with, such as a finished run, is then made once.
test: .venv/installed lint
	pytest -n $(CORES) --dist loadfile -rs

# The page in headless Chromium, which is Debian's package chromium. Without either the tests of it skip, and say why.
browser: .venv/installed
	@$(PIP) --no-deps --quiet --requirement environment-optional.txt || echo "no packages of environment-optional.txt"
	pytest tests/report/test_page_in_browser.py -rs

# A Slurm of one node on this machine: Debian's packages slurmctld, slurmd, slurm-client and munge. See docs/cluster.md.
cluster: .venv/installed
	@$(PIP) --quiet snakemake-executor-plugin-slurm==2.8.0
	AVS_CLUSTER=1 pytest tests/cluster -rs

# Random damage and kills, each against a run from nothing: hours. See docs/integrity.md.
endurance: .venv/installed
	python -m tests.endurance

lint: .venv/installed
	ruff check .
	ruff format --check .
	snakefmt --check Snakefile workflows/rules
	mypy

# The mark is written last, so that an interrupted installation is begun again. What pip says is kept, and shown where it
# fails.
.venv/installed: environment.txt
	$(PYTHON) -m venv --clear .venv
	@echo "installing the packages of environment.txt into .venv (.venv/pip.log)"
	@$(PIP) --no-deps --requirement environment.txt > .venv/pip.log 2>&1 || { tail -n 20 .venv/pip.log >&2; exit 1; }
	@$(PIP) --requirement <(grep '^torch==' environment.txt) >> .venv/pip.log 2>&1 || { tail -n 20 .venv/pip.log >&2; exit 1; }
	touch $@
