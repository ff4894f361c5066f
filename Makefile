# Everything that is done with this repository, one word each; `make help` lists them.

CARGO ?= cargo
# What `make run` passes on: make run ARGS="mountains.tif --stereo anaglyph"
ARGS ?=

# A fresh rustup is there before a new shell knows of it.
export PATH := $(PATH):$(HOME)/.cargo/bin

# Software GPU drivers complain in every run without one.
ifndef XDG_RUNTIME_DIR
export XDG_RUNTIME_DIR := $(CURDIR)/target/runtime
endif

.DEFAULT_GOAL := help
.PHONY: help deps deps-test deps-arm deps-bench run test test-arm lint bench doc runtime

help: ## List these words
	@sed -n 's/^\([a-z-]*\):.*## /  make \1|/p' $(MAKEFILE_LIST) | \
		awk -F'|' '{ printf "%-18s %s\n", $$1, $$2 }'

deps: ## Install what is missing to build and run (Debian; elsewhere: say what)
	@.ci/deps build run

deps-test: ## The same, and what the tests use besides
	@.ci/deps build run test

deps-arm: ## Install what is missing to build for 64-bit ARM, and to run that in emulation
	@.ci/deps build arm

deps-bench: ## Install what is missing to build, and Embree for the benches
	@.ci/deps build bench

run: deps runtime ## Open the table; without a display, write a flight; ARGS="..." goes to it
	$(CARGO) run --release --locked -- fly $(ARGS)

test: deps-test runtime ## Run all tests
	$(CARGO) test --workspace --locked

# Programs are linked as a whole, so that the emulator needs no system of that kind.
test-arm: deps-arm ## Run the casters' own tests on 64-bit ARM (NEON), in emulation
	RUSTFLAGS="-C target-feature=+crt-static" \
	CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
	CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=qemu-aarch64 \
	$(CARGO) test --release --locked --target aarch64-unknown-linux-gnu \
		-p sandtable-cast --lib --test instruction_sets

lint: deps runtime ## Check format, lints and documentation
	$(CARGO) fmt --all --check
	$(CARGO) clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --locked

bench: deps-bench ## Time the casters on 1 and 2 threads, the default one against itself, its level of detail, and Embree
	$(CARGO) bench --locked -p sandtable-cast --bench casters
	$(CARGO) bench --locked -p sandtable-cast --bench against_itself
	$(CARGO) bench --locked -p sandtable-cast --bench level_of_detail
	$(CARGO) bench --locked -p sandtable-cast --bench against_embree

doc: ## Build the documentation of all crates
	$(CARGO) doc --workspace --no-deps --locked
	@echo "See target/doc/sandtable/index.html"

runtime:
	@mkdir -p -m 700 "$$XDG_RUNTIME_DIR" || true
