#!/bin/sh
# Say in one sentence what is missing if the given Python cannot import bpy.
problem=$("$1" -c 'import bpy' 2>&1 >/dev/null) && exit 0
case $problem in
*"cannot open shared object file"*)
    echo "error: Blender's module lacks system libraries; on Debian: apt-get install $(cat "$(dirname "$0")/debian_packages.txt" | tr '\n' ' ')" >&2 ;;
*) echo "$problem" >&2 ;;
esac
exit 1
