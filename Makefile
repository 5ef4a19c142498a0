# make demo: the sample from nothing to G-code and pictures, in out/
# make test: all checks and tests
# make test-gui: in the window of the Blender that BLENDER names, by mouse and keys (Xvfb, xdotool, ImageMagick)
# make test-blender: what touches Blender, inside the Blender that BLENDER names (its Python needs pytest, hypothesis, …)
# make test-bpy: the same with another version of Blender's module, BPY=4.5.15 for example
# make package: the extension for Blender, in dist/
# make fuzz: damaged files for all readers, SECONDS each
# make benchmark: against a single-color slicer, where one is installed
.DELETE_ON_ERROR:
.PHONY: demo test test-gui test-blender test-bpy package benchmark fuzz environment lint clean

VENV := .venv
BIN := $(VENV)/bin
OUT := out

demo: environment
	./dualcolor demo --out $(OUT)

test: $(VENV)/.dev lint
	$(BIN)/python -m pytest

test-gui: $(VENV)/.dev
	$(BIN)/python -m pytest tests/gui -rs

# Python 3.11 is what Blender 4.5 and 5.0 come with, 3.13 the later ones.
BPY := 4.5.15
BPY_VENV := $(VENV)-bpy-$(BPY)
BPY_PYTHON := $(if $(filter 4.% 5.0.%,$(BPY)),3.11,3.13)

test-blender:
	$(or $(BLENDER),blender) -b --factory-startup --python-exit-code 1 --python tests/run_in_blender.py

test-bpy: $(BPY_VENV)/.dev
	$(BPY_VENV)/bin/python tests/run_in_blender.py

$(BPY_VENV)/.dev:
	python=$$(tools/find_python.sh $(BPY_PYTHON)) && "$$python" -m venv --clear $(BPY_VENV)
	$(BPY_VENV)/bin/python -m pip install --quiet --disable-pip-version-check bpy==$(BPY) \
		"numpy$(if $(filter 3.11,$(BPY_PYTHON)),>=1.26$(COMMA)<2,>=2.2$(COMMA)<3)" shapely Pillow xatlas pytest hypothesis
	tools/check_bpy.sh $(BPY_VENV)/bin/python
	touch $@

COMMA := ,

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
	rm -rf $(VENV) $(VENV)-bpy-* $(OUT) dist
