#!/usr/bin/env bash
# Blender 5.3.0: `illum 3` of MTL is a mirror of colour Ks, and 7 is glass of colour Tf. Its importer takes Kd for the colour of
# both, and a roughness of 1 without Ns or Pr: mirrors with `Kd 0 0 0`, as the format means them, are black and matt, and
# so is glass, as a metal. With Kd = Ks, Pm 1, Pr 0, and Kd = Tf, Pm 0, Pr 0, they are what they should be.
#
# Needs Python 3.13, pip and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3.13}" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet bpy==5.3.0
cat > "$work/a.mtl" <<'MTL'
newmtl glass
Kd 0 0 0
Tf 1 1 1
Ni 1.5
illum 7
newmtl glass_with_kd
Kd 1 1 1
Tf 1 1 1
Ni 1.5
Pm 0
Pr 0
illum 7
newmtl mirror
Kd 0 0 0
Ks 0.9 0.9 0.9
illum 3
newmtl mirror_as_metal
Kd 0.9 0.9 0.9
Ks 0.9 0.9 0.9
Pm 1
Pr 0
illum 3
MTL
{
    printf 'mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n'
    for name in $(sed -n 's/^newmtl //p' "$work/a.mtl"); do printf 'usemtl %s\nf 1 2 3\n' "$name"; done
} > "$work/a.obj"
cat > "$work/read.py" <<'PY'
import bpy
import sys

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=sys.argv[1])
for material in sorted(bpy.data.materials, key=lambda m: m.name):
    node = material.node_tree and material.node_tree.nodes.get("Principled BSDF")
    if node:
        value = lambda name: node.inputs[name].default_value
        print(f"found {material.name}: colour {value('Base Color')[0]:.1f}, metallic {value('Metallic'):.0f}, "
              f"roughness {value('Roughness'):.0f}")
PY
seen=$("$work/venv/bin/python" "$work/read.py" "$work/a.obj" 2> /dev/null | sed -n 's/^found //p')
echo "$seen"
# As seen with bpy 5.3.0.
expected='glass: colour 0.0, metallic 1, roughness 1
glass_with_kd: colour 1.0, metallic 0, roughness 0
mirror: colour 0.0, metallic 1, roughness 1
mirror_as_metal: colour 0.9, metallic 1, roughness 0'
[ "$seen" = "$expected" ] || { echo "the behaviour has changed" >&2; exit 1; }
