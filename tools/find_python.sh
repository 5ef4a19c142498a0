#!/bin/sh
# Print the first Python that a bpy wheel exists for: 3.11 or 3.13, from PYTHON, the path, or pyenv; only VERSION if given.
#   find_python.sh [VERSION]
wanted=${1:-3.11 3.13}
fits() {
    "$1" -c 'import sys, venv, ensurepip; sys.exit("%d.%d" % sys.version_info[:2] not in sys.argv[1:])' $wanted >/dev/null 2>&1
}
for python in $PYTHON python3 python3.13 python3.11 python /usr/bin/python3.13 /usr/bin/python3.11 /usr/bin/python3 \
    "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.13*/bin/python3 "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.11*/bin/python3; do
    if fits "$python"; then
        "$python" -c 'import sys; print(sys.executable)'
        exit 0
    fi
done
echo "error: no Python $(echo "$wanted" | sed 's/ / or /') with venv was found: install one (Debian: python3 python3-venv) or name it, make PYTHON=…" >&2
exit 1
