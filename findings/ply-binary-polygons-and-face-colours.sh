#!/usr/bin/env bash
# trimesh 5.2.0 and meshio 5.3.5: valid binary PLY files that they cannot read. trimesh fails at polygons of different numbers of
# corners ("PLY is unexpected length!"), and meshio at any property of faces after the list of their vertices ("buffer size must
# be a multiple of element size"), such as colours. Both read the same files as triangles without colours of faces.
#
# Needs Python 3, pip and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3}" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet trimesh==5.2.0 meshio==5.3.5
cat > "$work/read.py" <<'PY'
import struct
import sys

import meshio
import trimesh

CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 2, 0)]


def write(path, faces, color):
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    header += f"element face {len(faces)}\nproperty list uchar uint vertex_indices\n"
    header += "".join(f"property uchar {c}\n" for c in ("red", "green", "blue") if color) + "end_header\n"
    with open(path, "wb") as out:
        out.write(header.encode())
        out.writelines(struct.pack("<3f", *corner) for corner in CORNERS)
        for face in faces:
            out.write(struct.pack(f"<B{len(face)}I", len(face), *face) + color)


def outcome(read, path):
    try:
        read(path)
        return "read"
    except Exception as problem:
        return str(problem).split(":")[0].strip("!")


FILES = {
    "triangles": ([(0, 1, 2), (0, 2, 3), (3, 2, 4)], b""),
    "mixed polygons": ([(0, 1, 2, 3), (3, 2, 4)], b""),
    "colours of faces": ([(0, 1, 2), (0, 2, 3), (3, 2, 4)], b"\xff\x80\x00"),
}
for name, (faces, color) in FILES.items():
    path = f"{sys.argv[1]}/a.ply"
    write(path, faces, color)
    print(f"{name}: trimesh {outcome(trimesh.load, path)}; meshio {outcome(meshio.read, path)}")
PY
seen=$("$work/venv/bin/python" "$work/read.py" "$work" 2> /dev/null)
echo "$seen"
# As seen with trimesh 5.2.0 and meshio 5.3.5.
expected='triangles: trimesh read; meshio read
mixed polygons: trimesh PLY is unexpected length; meshio read
colours of faces: trimesh read; meshio buffer size must be a multiple of element size'
[ "$seen" = "$expected" ] || { echo "the behaviour has changed" >&2; exit 1; }
