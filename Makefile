# The two commands: `make demo` and `make test`. Both set everything up on a fresh Debian 12.
BUILD ?= build
OUT ?= out/demo
JOBS ?= $(shell nproc)
WERROR ?= OFF
CMAKE_FLAGS ?=
ARGS ?=
LINT_FLAGS ?=
CXX_FILES = $(shell git ls-files 'src/*.cpp' 'src/*.h' 'tools/*.cpp' 'tools/*.h' 'tests/*.cpp' 'tests/*.h' 'bench/*.cpp' 'bench/*.h')

.PHONY: help demo test test-sanitize kitti live crash endurance bench evaluate deps build format lint clean

help:  ## show this list
	@grep -hE '^[a-z-]+:.*##' Makefile | sed -E 's/:.*## /\t/' | expand -t 16

demo: build  ## simulate a flat, map it, say what came out and where, make a report to look at
	tools/demo.sh $(BUILD) $(OUT)

test: build  ## all tests; those on real data skip, saying so, where ../shared/data is absent
	ctest --test-dir $(BUILD) --output-on-failure -j $(JOBS)

test-sanitize:  ## unit tests under address and undefined-behaviour sanitizers
	$(MAKE) build BUILD=$(BUILD)-sanitize CMAKE_FLAGS="-DHGG_SANITIZE=ON -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O1"
	ctest --test-dir $(BUILD)-sanitize --output-on-failure -j $(JOBS) -LE realdata

kitti: build  ## map real LiDAR frames and hold the result against the annotated cars
	tests/kitti_test.sh $(BUILD) $(BUILD)/kitti

live: build  ## play a log over real LCM, loopback only, and hold the map against a replay
	tests/live_test.sh $(BUILD) $(BUILD)/live

crash: build  ## kill a live run 200 times and see that its map is there
	tests/crash_test.py 200 $(BUILD) $(BUILD)/crash

endurance: build  ## map 100 km of a simulated ring road under a budget of 64 MB; plots memory against the way
	$(BUILD)/hgg-endurance --kilometres 100 --budget-mb 64 --out $(BUILD)/endurance
	tools/endurance/plot.py $(BUILD)/endurance $(BUILD)/endurance/memory.png

bench: build  ## time the stages
	$(BUILD)/hgg_bench

evaluate: build  ## measure everything: docs/evaluation.md and .html (hours; ARGS="--frames 400 --loop-frames 600 --paths 07": less; ARGS=--quick: minutes)
	tools/matrix/run.py --build $(BUILD) $(ARGS)

deps:  ## install what is missing (Debian packages)
	tools/install_deps.sh

build: deps  ## configure and compile
	cmake -S . -B $(BUILD) -G Ninja -DHGG_WERROR=$(WERROR) $(CMAKE_FLAGS)
	cmake --build $(BUILD) -j $(JOBS)

format:  ## rewrite the code as .clang-format says
	clang-format -i $(CXX_FILES)

lint: deps  ## formatting and clang-tidy; changes nothing (LINT_FLAGS=--quick: without the static analyzer)
	tools/install_deps.sh --lint
	clang-format --dry-run -Werror $(CXX_FILES)
	cmake -S . -B $(BUILD)-lint -G Ninja -DHGG_FAST_BUILD=OFF
	cmake --build $(BUILD)-lint --target lcmtypes
	JOBS=$(JOBS) tools/lint.py $(LINT_FLAGS) $(BUILD)-lint

clean:  ## remove what was built and made
	rm -rf $(BUILD) $(BUILD)-sanitize $(BUILD)-lint out
