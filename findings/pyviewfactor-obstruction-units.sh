#!/usr/bin/env bash
# pyviewfactor 1.1.0: what blocks the view depends on the unit of length. A ray passes a triangle if the determinant of
# their intersection, twice the area of the triangle times the length of the ray times a cosine, is below 1e-6, an
# absolute number in cubic units. Two squares with a third one of the same size halfway between exchange nothing, as
# they should, with sides of 1 or 0.02, and 0.1998, as if nothing were between them, with sides of 0.005: parts of a
# device in metres. Neither an error nor a warning; the factors themselves do not depend on the unit. Models of small
# parts need smaller units.
#
# Needs Python 3, pip and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3}" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet pyviewfactor==1.1.0
cat > "$work/blocked.py" <<'PY'
import numpy as np
import pyviewfactor
import pyvista


def square(z, up):
    corners = [(0, 0, z), (1, 0, z), (1, 1, z), (0, 1, z)]
    return corners if up else corners[::-1]


# The one between has two sides, as a sheet has.
points = np.array([square(0, True), square(1, False), square(0.5, True), square(0.5, False)], float).reshape(-1, 3)
faces = np.array([[4, *range(4 * k, 4 * k + 4)] for k in range(4)]).ravel()
for side in (1, 0.02, 0.005):
    mesh = pyvista.PolyData(side * points, faces)
    factors = pyviewfactor.compute_viewfactor_matrix(mesh, obstacles=mesh)
    alone = pyviewfactor.compute_viewfactor_matrix(mesh, skip_obstruction=True)
    print(f"found side {side}: {factors[0, 1]:.4f}; without obstruction {alone[0, 1]:.4f}")
PY
seen=$("$work/venv/bin/python" "$work/blocked.py" 2> /dev/null | sed -n 's/^found //p')
echo "$seen"
# As seen with pyviewfactor 1.1.0.
expected='side 1: 0.0000; without obstruction 0.1998
side 0.02: 0.0000; without obstruction 0.1998
side 0.005: 0.1998; without obstruction 0.1998'
[ "$seen" = "$expected" ] || { echo "the behaviour has changed" >&2; exit 1; }
