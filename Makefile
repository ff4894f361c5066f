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
.PHONY: help deps deps-test deps-bench run test lint bench doc runtime

help: ## List these words
	@sed -n 's/^\([a-z-]*\):.*## /  make \1|/p' $(MAKEFILE_LIST) | \
		awk -F'|' '{ printf "%-18s %s\n", $$1, $$2 }'

deps: ## Install what is missing to build and run (Debian; elsewhere: say what)
	@.ci/deps build run

deps-test: ## The same, and what the tests use besides
	@.ci/deps build run test

deps-bench: ## Install what is missing to build, and Embree for the benches
	@.ci/deps build bench

run: deps runtime ## Open the table; without a display, write a flight; ARGS="..." goes to it
	$(CARGO) run --release --locked -- fly $(ARGS)

test: deps-test runtime ## Run all tests
	$(CARGO) test --workspace --locked

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
