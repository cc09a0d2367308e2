# Two commands: `make run` does the main job, `make test` passes every test.
# Both fetch what they need (crates, and the native libraries from PyPI wheels); nothing is installed.
# `make run` needs MuJoCo's library alone; `make test` and FEATURES=torch also fetch libtorch.

# One thread per tensor operation: two OpenMP threads on small matrices are 10 times slower.
export OMP_NUM_THREADS := 1

SPEC    ?= specs/atlas_run_torque.toml
PROFILE ?= quick
# Features beside the default ones: `make build FEATURES=torch` adds the learner's backend on libtorch.
FEATURES ?=
BINARY  := $(or $(CARGO_TARGET_DIR),target)/release/specforge
# Builds the documentation; cargo checks every dependency against the hashes in its lock file.
MDBOOK  := target/tools/bin/mdbook
MDBOOK_VERSION := 0.4.52

.PHONY: run build test docs native requirements

run: build
	$(BINARY) run $(SPEC) --profile $(PROFILE)

build: native
	cargo build --release --locked --features "$(FEATURES)"

test: requirements
	python3 tools/fetch_native.py torch
	cargo test --locked --features torch

docs: $(MDBOOK)
	$(MDBOOK) build docs

$(MDBOOK):
	cargo install --locked --version $(MDBOOK_VERSION) --no-default-features --features search \
	  --root target/tools mdbook

native: requirements
	python3 tools/fetch_native.py $(filter torch,$(FEATURES))

# Names what is missing before anything starts.
requirements:
	@missing=; \
	command -v cargo >/dev/null || missing="$$missing\n  cargo: install Rust 1.95 or newer with rustup"; \
	command -v c++ >/dev/null || missing="$$missing\n  c++: install a C++ compiler (g++ or clang)"; \
	command -v python3 >/dev/null || missing="$$missing\n  python3: install Python 3"; \
	! command -v python3 >/dev/null || python3 -m pip --version >/dev/null 2>&1 || missing="$$missing\n  pip: install pip for python3"; \
	if [ -n "$$missing" ]; then printf "specforge cannot be built, these are missing:$$missing\n" >&2; exit 1; fi
