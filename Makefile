# make setup   everything that the program needs, into .venv (and the system libraries of gmsh and VTK), and its kernels compiled
# make demo    set-up, then the main job: an aqueduct under a sinusoidal load, to out/demo/crack_map.png
# make test    set-up, then the core tests of every package
# make test-all        make test, then all tests that are marked slow; it judges how long each takes, and wants Chromium for those of pages
# make check   set-up, then lint, format, types, and which package imports which, that all imports are declared, and spelling
# make docs    set-up, then the documentation as a site: out/docs/index.html
# make validation      set-up, then the long comparisons with published numbers, closed forms and limit analysis; it prints their tables
# make test-portable   set-up, then the numerical tests with kernels compiled for any x86-64 and for this very processor: rounding differs there
# make test-elsewhere  set-up, then the core tests as on a system without what POSIX and Linux alone have
# make wheel   set-up, then dist/: a pure wheel, and one with the kernels compiled for this Python on any x86-64 with AVX2 and FMA
# make clean   drops what numba has compiled
# A second run skips what is done. Another Python: make setup PYTHON=python3.13

PYTHON ?= python3
VENV   := .venv
STAMP  := $(VENV)/.installed
WARM   := $(VENV)/.compiled
DEMO   := out/demo/crack_map.png
CODE   := $(shell find masonry_cd structures loads reports -name "*.py") $(wildcard reports/page/* reports/templates/* reports/templates/run/*)

# Tests whose outcome could depend on rounding, and so on whether kernels multiply and add in one instruction
NUMERICAL := tests/mechanics/friction tests/mechanics/linalg tests/mechanics/solvers tests/mechanics/contact tests/mechanics/dynamics/test_stepping.py
as         = $(2) NUMBA_CACHE_DIR=$(CURDIR)/.cache/numba-$(1) $(VENV)/bin/python -m pytest

# Debian package and the library that it brings, for gmsh (first five, OpenMP) and off-screen VTK (EGL)
LIBRARIES := libglu1-mesa:libGLU.so.1 libgl1:libGL.so.1 libxcursor1:libXcursor.so.1 libxft2:libXft.so.2 \
             libxinerama1:libXinerama.so.1 libgomp1:libgomp.so.1 libegl1:libEGL.so.1

# Processes of the tests keep what Python compiles of their sources, or else each of them compiles it again, tests above all.
unexport PYTHONDONTWRITEBYTECODE

# On all cores, up to eight
TESTS        := $(VENV)/bin/python -m pytest --numprocesses auto --maxprocesses 8 --dist loadfile
TEST_KERNELS := $(or $(NUMBA_CACHE_DIR),.cache)/.compiled-for-tests

.PHONY: setup demo test test-all browser check docs validation test-portable test-elsewhere wheel clean libraries
.DELETE_ON_ERROR:

setup: libraries $(STAMP) $(WARM)
	@echo "Set up: $(VENV)/bin/masonry-cd"

# The demo compiles the kernels that it needs.
demo: libraries $(STAMP)
	@$(MAKE) --no-print-directory $(DEMO)
	@echo "Demo: see $(DEMO) and out/demo/summary.json"

test: libraries $(STAMP) $(TEST_KERNELS)
	$(TESTS) $(BUDGET)

test-all: BUDGET := --budget
test-all: browser test
	$(TESTS) $(BUDGET) -m "slow and not validation"

# What the tests of pages drive; they are skipped without it.
browser:
	@command -v chromium >/dev/null && command -v chromedriver >/dev/null && exit 0; \
	as_root=; [ "$$(id -u)" = 0 ] || as_root="sudo -n"; \
	if command -v apt-get >/dev/null && { [ -z "$$as_root" ] || sudo -n true 2>/dev/null; }; then \
	  echo "Installing Chromium for the tests of pages"; \
	  $$as_root apt-get update -qq && $$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium chromium-driver && exit 0; \
	fi; \
	echo "No Chromium here, and no right to install it: the tests of pages in a browser are skipped (sudo apt-get install -y chromium chromium-driver)" >&2

check: libraries $(STAMP)
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/python .ci/license_headers.py --check
	$(VENV)/bin/mypy
	$(VENV)/bin/lint-imports --no-logo
	$(VENV)/bin/deptry masonry_cd structures loads reports
	$(VENV)/bin/codespell README.md CONTRIBUTING.md CHANGELOG.md docs masonry_cd structures loads reports examples benchmarks

docs: libraries $(STAMP)
	@NO_MKDOCS_2_WARNING=1 $(VENV)/bin/python -m mkdocs build --quiet --strict -f docs/site/mkdocs.yml
	@echo "Documentation: see out/docs/index.html"

validation: libraries $(STAMP)
	$(VENV)/bin/python -m pytest -m validation -s

# What is compiled is kept in .cache, so that a second run is quick.
test-portable: libraries $(STAMP)
	$(call as,generic,NUMBA_CPU_NAME=generic NUMBA_CPU_FEATURES=) $(NUMERICAL)
	$(call as,native,MASONRY_CD_NATIVE=1) $(NUMERICAL)

test-elsewhere: libraries $(STAMP) $(TEST_KERNELS)
	PYTHONPATH=tests/other_system $(TESTS)

# The kernels are compiled for x86-64-v3, whatever the processor of this machine has beyond it, and kept in .cache/kernels.
wheel: libraries $(STAMP)
	rm -rf .cache/kernels
	env -u MASONRY_CD_NATIVE -u NUMBA_CPU_NAME -u NUMBA_CPU_FEATURES NUMBA_CACHE_DIR=$(CURDIR)/.cache/kernels $(VENV)/bin/python -m masonry_cd.app.compile_all $(filter-out examples/study_% %_record.toml,$(wildcard examples/*.toml))
	$(VENV)/bin/python -m pip wheel --quiet --disable-pip-version-check --no-deps -w dist .
	MASONRY_CD_KERNELS=$(CURDIR)/.cache/kernels $(VENV)/bin/python -m pip wheel --quiet --disable-pip-version-check --no-deps -w dist .
	@ls -l dist

clean:
	rm -rf .cache $(WARM)
	find masonry_cd structures loads reports benchmarks tests -name '*.nb[ci]' -delete

$(DEMO): examples/aqueduct_sinusoidal.toml $(STAMP) $(CODE)
	$(VENV)/bin/masonry-cd run examples/aqueduct_sinusoidal.toml -o out/demo --force

$(STAMP): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "masonry-cd needs Python 3.11 or newer as $(PYTHON); name another one: make setup PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || \
	  { echo "Python's venv module is missing. Type this, then make again:" >&2; echo "    sudo apt-get install -y $(notdir $(PYTHON))-venv" >&2; exit 1; }
	@$(VENV)/bin/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv --clear $(VENV)
	$(VENV)/bin/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	@touch $@

$(WARM): $(STAMP) $(CODE)
	@$(VENV)/bin/python -m masonry_cd.app.warmup
	@touch $@

# Before the tests, or else each process would compile them
$(TEST_KERNELS): $(STAMP) $(CODE) tests/kernels.py
	@echo "Compiling the kernels that the tests reach, in two processes: some minutes the first time"
	@PYTHONPATH=tests $(VENV)/bin/python -m kernels
	@mkdir -p $(@D) && touch $@

# Installed by apt-get where root or a sudo without password allows; otherwise the line to type is printed.
libraries:
	@found=$$(PATH="$$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null); missing=; \
	for pair in $(LIBRARIES); do \
	  case "$$found" in *"$${pair#*:}"*) ;; *) missing="$$missing $${pair%%:*}" ;; esac; \
	done; \
	[ -n "$$missing" ] || exit 0; \
	as_root=; [ "$$(id -u)" = 0 ] || as_root="sudo -n"; \
	if command -v apt-get >/dev/null && { [ -z "$$as_root" ] || sudo -n true 2>/dev/null; }; then \
	  echo "Installing system libraries:$$missing"; \
	  $$as_root apt-get update -qq && $$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $$missing && exit 0; \
	fi; \
	echo "System libraries of gmsh and VTK are missing. Type this, then make again:" >&2; \
	echo "    sudo apt-get install -y$$missing" >&2; \
	exit 1
