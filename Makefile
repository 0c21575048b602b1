# Every target sets up what it needs, in a virtual environment, and is quick the second time.
# Tests start many processes, each of which would compile all modules without their bytecode.
unexport PYTHONDONTWRITEBYTECODE
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
BASE_READY := $(VENV)/.ready-base
READY := $(VENV)/.ready
BENCH_READY := $(VENV)/.ready-bench
OUT := out
# Three processes keep two cores busy while tests wait for what they start. The order in which they
# take the files is that of tests/conftest.py.
PYTEST := $(BIN)/python -m pytest --numprocesses 3 --dist loadfile --no-loadscope-reorder --quiet
# Public maps that some benchmarks use; where there are none, they are left out.
MULTISRT_MAPS ?= ../shared/maps

# Missions that a campaign makes and judges.
MISSIONS ?= 2000

.PHONY: help demo test check tutorial campaign golden plan pictures lint types style imports bench results docs linkcheck clean

help:
	@echo "make demo     a team of four explores the museum with SRT-Radial and SRT-Star; pictures in $(OUT)/demo"
	@echo "make test     run the tests"
	@echo "make check    run the tests that are not marked slow"
	@echo "make tutorial run the whole tutorial on your own strategy, and compare its output with the page"
	@echo "make campaign make $(MISSIONS) missions that are drawn over all there is, and judge them (MISSIONS=N); resumes where it stopped"
	@echo "make golden   rewrite the digests of the golden runs, after an intended change of behaviour"
	@echo "make plan     draw docs/pictures/plan.svg from the imports"
	@echo "make pictures draw all pictures of the documentation, docs/pictures"
	@echo "make lint     check style, types, import rules and that the documentation builds"
	@echo "make bench    measure speed, each claim beside what it is compared with (MULTISRT_MAPS: a folder of public maps)"
	@echo "make results  repeat the experiments of the papers, over many seeds (many hours); resumes where it stopped"
	@echo "make docs     build the documentation in site/"
	@echo "make linkcheck  check the documentation's links to other sites"
	@echo "make clean    remove the virtual environment and all that was generated"

$(BASE_READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; (3, 11) <= sys.version_info[:2] <= (3, 13) or sys.exit("multisrt needs Python 3.11 to 3.13, not %d.%d: make PYTHON=python3.12" % sys.version_info[:2])'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt pip setuptools
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable .
	@touch $(BASE_READY)

$(READY): $(BASE_READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[plots,frames,polars,parquet,cluster,learn,animation,dxf,mcap,rerun,test,lint,bench,docs]'
	@touch $(READY)

demo: $(BASE_READY)
	$(BIN)/multisrt explore museum --robots 4 --strategy srt-radial --strategy srt-star --seed 1 --out $(OUT)/demo --force
	@echo
	@echo "Open the trees in a browser or in Inkscape:"
	@echo "  $(OUT)/demo/srt-radial/tree.svg"
	@echo "  $(OUT)/demo/srt-star/tree.svg"

test: $(READY)
	$(PYTEST)

check: $(READY)
	$(PYTEST) -m "not slow"

# The tests make it with two worlds instead of twenty.
tutorial: $(READY)
	MULTISRT_WHOLE=1 $(BIN)/python -m pytest --quiet tests/docs/test_tutorial.py

campaign: $(READY)
	$(BIN)/multisrt campaign run --missions $(MISSIONS) --workers 2 --store $(OUT)/campaign/missions.sqlite

golden: $(READY)
	$(BIN)/python tests/golden/golden_runs.py

plan: $(READY)
	$(BIN)/python docs/plan.py

pictures: $(READY) plan
	$(BIN)/python docs/figures

# Two jobs check the types and build the documentation at the same time.
lint: types docs style imports

types: $(READY)
	$(BIN)/mypy

style: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

imports: $(READY)
	$(BIN)/lint-imports

# VisiLibity comes as source only: swig writes its bindings, and a C++ compiler builds them.
$(BENCH_READY): $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt swig wheel
	@PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --no-build-isolation VisiLibity \
		|| echo "VisiLibity cannot be built here (it needs a C++ compiler): the line that compares with it will be skipped"
	@touch $(BENCH_READY)

bench: $(BENCH_READY)
	MULTISRT_MAPS="$(MULTISRT_MAPS)" $(BIN)/python -m benchmarks

# A run that fails ends its experiment with an error at the end; the others are made all the same.
results: $(READY)
	@failed=; \
	for paper in multi-srt sbx-r minpos alvarez; do \
		$(BIN)/multisrt reproduce $$paper --out $(OUT)/results/$$paper || failed="$$failed $$paper"; \
		cp $(OUT)/results/$$paper/summary.md docs/results/$$paper.md; \
		$(BIN)/multisrt experiment export --force $(OUT)/results/$$paper/results.sqlite docs/results/$$paper.csv; \
	done; \
	$(BIN)/python docs/verdicts.py; \
	if [ -n "$$failed" ]; then echo "runs failed or are missing in:$$failed"; exit 1; fi

# Warnings are errors: links to pages, anchors and the API that lead nowhere, and pages left out.
docs: $(READY)
	$(BIN)/sphinx-build --fail-on-warning --nitpicky --quiet --builder html docs site

linkcheck: $(READY)
	$(BIN)/sphinx-build --quiet --builder linkcheck docs build/linkcheck

clean:
	rm -rf $(VENV) $(OUT) build site *.egg-info .pytest_cache .mypy_cache .ruff_cache .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
