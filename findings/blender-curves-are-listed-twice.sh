#!/usr/bin/env bash
# Blender 5.3.0: `depsgraph.object_instances` lists curves, texts and metaballs that have faces twice: as themselves, and
# as instances of themselves that are meshes. Who takes every entry that has a surface has each of them twice in one
# place.
#
# Needs Python 3.13, pip and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3.13}" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet bpy==5.3.0
cat > "$work/list.py" <<'PY'
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
curve = bpy.data.curves.new("curve", "CURVE")
curve.dimensions, curve.bevel_depth = "3D", 0.1
curve.splines.new("POLY").points.add(1)
curve.splines[0].points[1].co = (1, 0, 0, 1)
text = bpy.data.curves.new("text", "FONT")
text.body = "a"
ball = bpy.data.metaballs.new("ball")
ball.elements.new()
mesh = bpy.data.meshes.new("mesh")
mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
for data in (curve, text, ball, mesh):
    bpy.context.collection.objects.link(bpy.data.objects.new(data.name, data))
for instance in bpy.context.evaluated_depsgraph_get().object_instances:
    print(f"found {instance.object.name}: {instance.object.type}{' instance' if instance.is_instance else ''}")
PY
seen=$("$work/venv/bin/python" "$work/list.py" 2> /dev/null | sed -n 's/^found //p')
echo "$seen"
# As seen with bpy 5.3.0.
expected='curve: CURVE
curve: MESH instance
text: FONT
text: MESH instance
ball: META
ball: MESH instance
mesh: MESH'
[ "$seen" = "$expected" ] || { echo "the behaviour has changed" >&2; exit 1; }
