# make demo: the sample from nothing to G-code and pictures, in out/
# make test: all checks and tests
# make test-gui: in the window of the Blender that BLENDER names, by mouse and keys (Xvfb, xdotool, ImageMagick)
# make package: the extension for Blender, in dist/
# make fuzz: damaged files for all readers, SECONDS each
# make benchmark: against a single-colour slicer, where one is installed
.DELETE_ON_ERROR:
.PHONY: demo test test-gui package benchmark fuzz environment lint clean

VENV := .venv
BIN := $(VENV)/bin
OUT := out

demo: environment
	./dualcolor demo --out $(OUT)

test: $(VENV)/.dev lint
	$(BIN)/python -m pytest

test-gui: $(VENV)/.dev
	$(BIN)/python -m pytest tests/gui -rs

lint: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	@# NumPy's own types differ between versions; ours are written for those of the lowest one.
	if $(BIN)/python -c 'import sys; sys.exit(sys.version_info >= (3, 12))'; then $(BIN)/mypy; fi

package: environment
	$(BIN)/python tools/package.py --out dist

benchmark: environment
	$(BIN)/python benchmarks/slicers.py

fuzz: environment
	$(BIN)/python tests/fuzz/run.py --seconds $(or $(SECONDS),60)

environment: $(VENV)/.runtime

$(VENV)/.runtime: requirements.txt
	python=$$(PYTHON="$(PYTHON)" tools/find_python.sh) && "$$python" -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.txt
	tools/check_bpy.sh $(BIN)/python
	touch $@

$(VENV)/.dev: $(VENV)/.runtime requirements-dev.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements-dev.txt
	touch $@

clean:
	rm -rf $(VENV) $(OUT) dist
