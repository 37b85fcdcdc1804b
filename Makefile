# make            build the environment, run the study to results/report/thesis.pdf; after a run that was killed, go on
# make CONFIG=... the same for a study of your own, for example CONFIG=my-study/config.yaml
# make test       build the environment if needed, run the tests
# make quick      the same without tests that are slow or run a study
# make soak       the same for the campaign of damaged files, bad inputs and kills: at most 60 minutes (benchmarks/soak)
# make lint       the same for the lint, format and type checks
# make format     rewrite the code in the project's format, and the tables of config/README.md
# make docs       build the site into site/, with the outputs of the tutorials and a demonstration study
# make wheel-test build a wheel, install it into an environment of its own, run the library's tests and a study there
#
# make PYTHON=... another interpreter: CPython 3.11 (which alone has PyBullet), 3.12 or 3.13

# text of the user in a command of the shell, which takes it as it is
quoted = '$(subst ','\'',$(1))'
# that of the environment once there is one
PYTHON ?= $(shell .venv/bin/python -c 'import sys; print(sys._base_executable)' 2>/dev/null || \
	command -v python3.11 || command -v python3)
VERSION := $(shell $(call quoted,$(PYTHON)) -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)
BIN := .venv/bin
CORES ?= 2

.PHONY: study test quick soak lint format docs environment wheel-test

# where PyBullet is not installed, another engine moves the simulated dummy
ENGINE = $$($(BIN)/python -c 'import pybullet' 2>/dev/null || echo --configfile config/any-engine.yaml)

# checks the configuration before Snakemake loads it, and goes on after a run that was killed
study: environment
	@$(BIN)/python -m workflow.run -c$(CORES) $(ENGINE) $(if $(value CONFIG),--configfile $(call quoted,$(value CONFIG)))

# processes share the files of tests, because those of one file may change the same study; files that run a study
# start first
PYTEST = $(BIN)/python -m pytest -n $(CORES) --dist loadfile --no-loadscope-reorder

test: environment
	$(PYTEST)

quick: environment
	$(PYTEST) -m "not slow and not study"

soak: environment
	$(BIN)/python benchmarks/soak/soak.py --cores $(CORES) $(SOAK)

lint: environment
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/snakefmt --check Snakefile workflow/rules workflow/studies
	$(BIN)/snakemake --lint
	$(BIN)/mypy

format: environment
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/snakefmt Snakefile workflow/rules workflow/studies
	$(BIN)/python -m workflow.settings

# tutorials and the demonstration are run if they are not those of the present sources
docs: .venv/docs-$(VERSION)
	$(BIN)/python docs/run_tutorials.py
	$(BIN)/python -m workflow.run -c$(CORES) --quiet all $(ENGINE) --configfile config/passive-cameras/config.yaml
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict --clean
	$(BIN)/python docs/check_site.py

.venv/docs-$(VERSION): .venv/complete-$(VERSION) docs/requirements.txt
	@if command -v uv >/dev/null; then \
		uv pip install --quiet --python $(BIN)/python --no-deps --require-hashes -r docs/requirements.txt ; \
	else \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r docs/requirements.txt ; \
	fi
	@touch $@

wheel-test:
	$(call quoted,$(PYTHON)) tests/installed_wheel.py --extra study -n $(CORES)

environment: .venv/complete-$(VERSION)

.venv/complete-$(VERSION): requirements.txt pyproject.toml
	@case "$$PWD" in *[\$$\`\"\\:]*) \
		printf 'tepsipe: %s: expected a folder without $$, `, ", \\ and :, because scripts of an environment give its path to a shell, found one: rename it\n' "$$PWD"; exit 1;; \
	esac
	@case "$(VERSION)" in 3.11|3.12|3.13) ;; *) \
		printf "tepsipe needs CPython 3.11, 3.12 or 3.13, found $(or $(VERSION),nothing that runs) at '%s': install one of them, or say where it is with make PYTHON=...\n" $(call quoted,$(PYTHON)); exit 1;; \
	esac
	@if command -v uv >/dev/null; then \
		uv venv --quiet --clear --python $(call quoted,$(PYTHON)) .venv && \
		uv pip install --quiet --compile-bytecode --python $(BIN)/python --require-hashes -r requirements.txt && \
		uv pip install --quiet --python $(BIN)/python --no-deps --no-build-isolation -e . ; \
	else \
		$(call quoted,$(PYTHON)) -m venv --clear .venv && \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.txt && \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e . ; \
	fi
	@touch $@
