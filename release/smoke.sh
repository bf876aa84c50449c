#!/usr/bin/env bash
# Tries what release/archive.sh and release/python.sh made for this machine's platform:
#
#   release/smoke.sh [FOLDER]
#
# compares FOLDER (`dist` by default) and the content of its archive with their checksums, renders an
# example by the command of the archive, and computes a known form factor by the wheel, in an
# environment of its own, for which pip downloads NumPy. Needs Python 3.10.
set -euo pipefail
cd "$(dirname "$0")/.."
dist=$(cd "${1:-dist}" && pwd)
checksums=$PWD/release/checksums.py
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Nothing of the tree is found from here.
cd "$work"

python3 "$checksums" --check "$dist"
shopt -s nullglob
archives=("$dist"/azulejo-*.tar.gz "$dist"/azulejo-*.zip)
wheels=("$dist"/pyazulejo-*.whl)
if [ ${#archives[@]} -ne 1 ] || [ ${#wheels[@]} -ne 1 ]; then
    echo "$dist has ${#archives[@]} archives and ${#wheels[@]} wheels: expected one of each" >&2
    exit 1
fi

python3 -c 'import shutil, sys; shutil.unpack_archive(*sys.argv[1:])' "${archives[0]}" .
root=$(echo azulejo-*)
python3 "$checksums" --check "$root"
"$root/bin/azulejo" render "$root/examples/cornell.grf" -o cornell.png --size 64x64
"$root/bin/azulejo" --version

python3 -m venv environment
python=environment/bin/python
[ -x "$python" ] || python=environment/Scripts/python.exe
"$python" -m pip install --quiet "${wheels[0]}"
"$python" - << 'PYTHON'
import numpy as np
import pyazulejo as az

square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
scene = az.Scene({"floor": (square, [[0, 1, 2, 3]]), "lid": (square + [0, 0, 1], [[3, 2, 1, 0]])})
f = az.form_factors(scene, by="object")
opposite = f["floor", "lid"]
print(f"F = {opposite:.5f} +- {opposite.std_error:.5f} between opposite faces of a cube: 0.19982")
assert opposite.std_error < 0.002 and abs(opposite - 0.199825) < 5 * opposite.std_error + 1e-6
PYTHON
