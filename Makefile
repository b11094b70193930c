# Two commands do everything: `make run` and `make test`. `make help` lists the rest.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready
DEV    := $(VENV)/.ready-dev
SITE   := $(VENV)/.ready-docs
# a module is compiled when it is loaded first; most of those that are installed never are
INSTALL := $(BIN)/pip --quiet --disable-pip-version-check install --no-compile

# tests start many processes, which load the modules that the first one compiled; containers often set
# this variable, and then each of them compiles all modules again
unexport PYTHONDONTWRITEBYTECODE

# all tests of a file in one process, so that what they share is made once; files in their order,
# which ends with short ones
SIDE_BY_SIDE := -n 2 --dist loadfile --no-loadscope-reorder

.PHONY: help run quick missing build platforms gateway machine docs links test test-all tests golden fuzz check check-style check-types check-rust check-gateway programs format bench results results-studies results-measured clean lock

help:
	@echo "make run       set up, build the FMUs, run the paper's cases, write the report"
	@echo "make quick     the same on a short trajectory, into out/quick"
	@echo "make missing   what the model lacks: found from logs, added, shown (minutes)"
	@echo "make platforms FMUs for Linux, Windows, macOS and ARM at once (400 MB of compiler)"
	@echo "make gateway   build the drive gateway (Rust)"
	@echo "make machine   the adaptive loop on emulated EtherCAT drives (root; minutes)"
	@echo "make docs      build the site from docs/ into out/docs (opens without a network)"
	@echo "make links     do the addresses of other sites in docs/ answer? (wants a network)"
	@echo "make test      linters, types, formatting and the tests (large suites sampled)"
	@echo "make test-all  the same with every test in full"
	@echo "make golden    write the golden results of the FMUs anew"
	@echo "make fuzz      a million random calls on each FMU, under sanitizers; a million spoiled replies on the gateway"
	@echo "make check     linters, types, formatting (gateway/ too, where cargo is)"
	@echo "make bench     speed: beside rivals, beside the recorded revision (fails on 15 % slower; minutes)"
	@echo "make results   measure the short figures anew, write them into README and docs (commit first)"
	@echo "make results-studies  the long ones (hours; root for the emulated drives)"
	@echo "make results-measured  measured machines of others, whose data is below data/"
	@echo "make format    format Python, C and Rust"
	@echo "make lock      resolve all requirements*.lock anew"
	@echo "make clean     remove out/ and the environment"

# what runs: the product and its dependencies
$(READY): requirements.lock pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed") if sys.version_info < (3, 11) else 0'
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) --require-hashes -r requirements.lock
	$(INSTALL) --no-deps --no-build-isolation -e .
	@touch $@

# what tests it: importers, a second simulator, linters, type checker
$(DEV): requirements-dev.lock $(READY)
	$(INSTALL) --require-hashes -r requirements-dev.lock
	@touch $@

run: $(READY)
	$(BIN)/flexhex run

quick: $(READY)
	$(BIN)/flexhex run --quick

missing: $(READY)
	$(BIN)/flexhex run --only missing

build: $(READY)
	$(BIN)/flexhex build

platforms: $(READY)
	$(INSTALL) --require-hashes -r requirements-platforms.lock
	$(BIN)/flexhex build --platform linux64,win64,aarch64-linux,darwin64

gateway: $(READY)
	$(BIN)/python gateway/lock.py write
	cd gateway && cargo build --release --locked

machine: gateway
	$(BIN)/flexhex drive

# what builds the site; the notebook in it finds the FMUs in the cache
$(SITE): requirements-docs.lock $(READY)
	$(INSTALL) --require-hashes -r requirements-docs.lock
	@touch $@

docs: build $(SITE)
	$(BIN)/python docs/machine_reference.py
	$(BIN)/python docs/effects_reference.py
	$(BIN)/python docs/draw_frames.py
	$(BIN)/python docs/draw_lengths.py
	$(BIN)/sphinx-build -W --keep-going -q -b html docs out/docs
	@echo "out/docs/index.html"

# links inside the site are checked by its test; these are those that leave it
links: build $(SITE)
	$(BIN)/sphinx-build -q -b linkcheck -D nb_execution_mode=off docs out/links

# the checks beside the tests, which wait for hardware and clocks now and then; a check that fails
# shows at once what it says. Rust needs no environment, so it begins beside the installation
test:
	@$(MAKE) --no-print-directory --jobs 3 tests aside-style aside-types aside-rust

test-all:
	@$(MAKE) --no-print-directory --jobs 3 MORE=--all tests aside-style aside-types aside-rust

tests: $(DEV)
	$(BIN)/pytest $(SIDE_BY_SIDE) $(MORE)

aside-style aside-types: $(DEV)
aside-style aside-types aside-rust: aside-%:
	@mkdir -p out && $(MAKE) --no-print-directory check-$* $(if $(filter rust,$*),programs) \
	  > out/check-$*.log 2>&1 || { cat out/check-$*.log; exit 1; }

golden: $(DEV)
	$(BIN)/pytest tests/golden --update

# one in thirty of these replies is spoiled
fuzz: build gateway $(DEV)
	$(BIN)/python -m tests.conformity.fuzz out/fmus/*.fmu
	cd gateway && FLEXHEX_SSP=$(CURDIR)/out/hexapod.ssp FLEXHEX_REPLIES=30000000 \
	  cargo test --release --locked spoiled -- --nocapture

bench: $(DEV)
	$(BIN)/python -m benchmarks --long
	$(BIN)/python -m benchmarks --against recorded

RECORD := $(BIN)/python -m results.record
DATA   := data
DAY    := $(shell date +%y%m%d)

results: build $(DEV)
	$(RECORD) paper python -m flexhex run --only table --json
	$(RECORD) missing python -m flexhex run --only missing --json
	$(RECORD) speed python -m benchmarks --json
	$(BIN)/python -m results.render
	$(BIN)/flexhex export out/hexapod.ssp --trajectory examples/motion.csv
	$(BIN)/python -m results.plots

results-studies: build gateway $(DEV)
	$(RECORD) schunk python examples/schunk/diagnose.py --json
	$(RECORD) quantisation python -m studies.quantisation --json
	$(RECORD) drive python -m flexhex drive --json
	$(RECORD) hidden_effects python -m studies.hidden_effects --json --test --jobs 2 \
	  --generator $(DAY)000:$(DAY)080 --mujoco $(DAY)000:$(DAY)200 --axes $(DAY)000:$(DAY)060
	$(RECORD) sensitivity python -m studies.sensitivity --json \
	  --generator 7:10 --mujoco 200:214 --axes 6:9
	$(RECORD) machines python -m studies.showcase --json --seed $(DAY)
	$(BIN)/python -m results.render

# data of other people, below $(DATA): docs/measured-data.md says where from
results-measured: $(DEV)
	$(RECORD) measured python -m studies.measured $(DATA) --json
	$(BIN)/python -m results.render

# types, Rust and the rest side by side: nothing of the one waits for another
check: $(DEV)
	@$(MAKE) --no-print-directory --jobs 2 check-style check-types check-rust

check-style: $(DEV)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/clang-format --dry-run -Werror $$(git ls-files '*.c' '*.h')

check-types: $(DEV)
	$(BIN)/mypy

check-rust:
	@if cargo fmt --version && cargo clippy --version; then $(MAKE) --no-print-directory check-gateway; \
	else echo "gateway/ is not checked: no cargo with rustfmt and clippy on the PATH"; fi

check-gateway:
	$(PYTHON) gateway/lock.py write
	cd gateway && cargo fmt --all --check
	cd gateway && cargo clippy --release --locked --workspace --all-targets -- -D warnings

# what the tests of the gateway run, where there is cargo
programs: check-rust
	@if cargo --version; then cd gateway && cargo build --release --locked --workspace --all-targets; fi

format: $(DEV)
	$(BIN)/ruff check --fix-only .
	$(BIN)/ruff format .
	$(BIN)/clang-format -i $$(git ls-files '*.c' '*.h')
	@if cargo fmt --version; then cd gateway && cargo fmt --all; fi

# uv resolves for all platforms at once; without one on the PATH it comes into an environment of its own
UV      = $(or $(shell command -v uv),out/uv/bin/uv)
COMPILE = $(UV) pip compile --quiet --universal --python-version 3.11 --generate-hashes \
          --no-emit-index-url --no-header
lock:
	command -v uv || { $(PYTHON) -m venv out/uv && out/uv/bin/pip install --quiet uv; }
	$(COMPILE) --extra build pyproject.toml -o requirements.lock
	$(COMPILE) --extra build --extra dev -c requirements.lock pyproject.toml -o requirements-dev.lock
	$(COMPILE) --extra build --extra docs -c requirements-dev.lock pyproject.toml -o requirements-docs.lock
	grep -o 'ziglang[^"]*' pyproject.toml | $(COMPILE) --no-annotate - -o requirements-platforms.lock

clean:
	rm -rf out $(VENV)
