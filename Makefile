# Everything runs in the project's own virtual environment, which the first call makes.
VENV := .venv
PYTHON ?= python3
BIN := $(VENV)/bin
DEMO_INPUT := data/scans/kinect_milk.ply
DEMO_OUTPUT := out/kinect_milk_smooth.ply

.DEFAULT_GOAL := help
# Compiled modules are kept: tests rewrite theirs for 10 s otherwise, in each of their processes.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help demo test test-fast packages coverage docs man tables lint format bench bench-curvature bench-polyhedra bench-quality bench-scans bench-large fuzz fuzz-commands pictures experiments clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-15s %s\n", $$1, $$2 }' Makefile

$(VENV)/installed: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "pcsmooth needs Python 3.11 or later; try make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	@touch $@

demo: $(VENV)/installed ## set up, then denoise the shipped Kinect scan
	@mkdir -p out
	$(BIN)/pcsmooth denoise $(DEMO_INPUT) -o $(DEMO_OUTPUT) --overwrite
	@echo "The smoothed scan is $(DEMO_OUTPUT); open it in MeshLab, CloudCompare or Open3D."

test: $(VENV)/installed ## set up, then run all tests, two files at a time
	$(BIN)/pcsmooth warmup --all -q
	$(BIN)/python -m pytest -n 2 --dist loadfile

test-fast: $(VENV)/installed ## run the tests that take little time, and every fifth case of those that have many
	$(BIN)/pcsmooth warmup --all -q
	$(BIN)/python -m pytest -n 2 --dist loadfile --fast

packages: $(VENV)/installed ## build sdist and wheel, install each in a clean environment, denoise there
	@rm -rf out/packages && mkdir -p out
	@$(BIN)/python -m build --no-isolation --outdir out/packages > out/build.log 2>&1 || { cat out/build.log; exit 1; }
	.ci/packages out/packages $(BIN)/python data/scans/kinect_milk.ply

coverage: $(VENV)/installed ## run all tests; print which lines and branches none of them reaches
	$(BIN)/pcsmooth warmup --all -q
	$(BIN)/python -m pytest -n 2 --dist loadfile --cov --cov-report=term-missing:skip-covered

lint: $(VENV)/installed ## style and types
	$(BIN)/ruff check src tests docs
	$(BIN)/ruff format --check src tests docs
	$(BIN)/mypy

format: $(VENV)/installed ## lay out the code
	$(BIN)/ruff format src tests docs
	$(BIN)/ruff check --fix src tests docs

bench: $(VENV)/installed ## print a table of times and memory, beside a k-d tree query
	$(BIN)/python tests/benchmarks/bench_balls.py

bench-curvature: $(VENV)/peers ## print errors of normals and curvatures, beside other programs'
	$(BIN)/python tests/benchmarks/bench_curvature.py $(if $(DATA),--data '$(DATA)')

bench-polyhedra: $(VENV)/installed ## print speed, limits and shapes of unions of polyhedra
	$(BIN)/python tests/benchmarks/bench_polyhedra.py

bench-quality: $(VENV)/peers ## print how well clouds are denoised, beside other programs
	$(BIN)/python tests/benchmarks/bench_quality.py $(if $(DATA),--data '$(DATA)') $(if $(SHAPES),--shapes '$(SHAPES)') $(SECTIONS)

bench-scans: $(VENV)/installed ## print what becomes of scans of which the truth is known; ONLY=lines,hall
	$(BIN)/python tests/benchmarks/bench_scans.py $(if $(ONLY),--only '$(ONLY)')

bench-large: $(VENV)/installed ## denoise N=100000000 points in tiles in FOLDER; OPTIONS of denoise
	$(BIN)/python tests/benchmarks/large_cloud.py $(or $(N),100000000) '$(or $(FOLDER),/tmp)' \
		$(or $(OPTIONS),--scheme euler --iterations 1 --tile 2000000)

# DATA=DIR names a folder with what is not shipped: report/fandisk_simplified.xyz, the models
# meshes/*.ply and the scans/*.ply. SHAPES=spot,torus and SECTIONS='shapes speed' select.
$(VENV)/peers: $(VENV)/installed
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,peers]' \
		&& touch $@ || echo 'Going on without the programs that could not be installed.'

fuzz: $(VENV)/installed ## read damaged files; N=100000 of them, SEED=0
	$(BIN)/python tests/benchmarks/fuzz_readers.py $(if $(N),--inputs $(N)) $(if $(SEED),--seed $(SEED))

fuzz-commands: $(VENV)/installed ## run random command lines and presets; N=5000 of them, SEED=0
	$(BIN)/python tests/benchmarks/fuzz_commands.py $(if $(N),--runs $(N)) $(if $(SEED),--seed $(SEED))

$(VENV)/docs: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	@touch $@

docs: $(VENV)/docs ## build the documentation into out/docs and check it
	$(BIN)/python -m sphinx -W --keep-going -q -j 2 -b html -d out/doctrees docs out/docs
	$(BIN)/python docs/check_pages.py out/docs
	@echo "The documentation is out/docs/index.html."

tables: $(VENV)/docs ## measure again what the documentation's tables say; half an hour on a quiet machine
	@mkdir -p out
	$(BIN)/python tests/benchmarks/bench_balls.py > out/balls.md && mv out/balls.md docs/tables/balls.md
	$(BIN)/python tests/benchmarks/bench_polyhedra.py speed > out/polyhedra.md && mv out/polyhedra.md docs/tables/polyhedra.md
	$(BIN)/python tests/benchmarks/bench_quality.py choices > out/choices.md && mv out/choices.md docs/tables/choices.md
	$(BIN)/python tests/benchmarks/bench_scans.py > out/scans.md && mv out/scans.md docs/tables/scans.md

man: $(VENV)/docs ## build the man pages into out/man
	$(BIN)/python -m sphinx -q -b man -d out/doctrees-man docs out/man

pictures: $(VENV)/docs ## draw the README's picture again
	MPLBACKEND=agg $(BIN)/python docs/gallery/plot_before_after.py data/pictures/before_after.png

experiments: $(VENV)/installed ## do the thesis' experiments again, into out/experiments
	$(BIN)/pcsmooth experiments --out out/experiments --data '$(or $(DATA),data/report)' --overwrite

clean: ## remove the environment, caches and outputs
	rm -rf $(VENV) out build .pytest_cache .mypy_cache .ruff_cache src/*.egg-info
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +
