#!/usr/bin/env bash
# Blender 5.3.0: a lamp of 4 pi W, which is 1 W/sr, and a surface of emission strength 1, which is 1 W/(sr m2), are written to
# glTF as 683 cd and 1 cd/m2 with the default lighting mode, Standard: lamps are multiplied by 683 lm/W and surfaces are
# not, so that they are apart by that factor wherever the file is read by the standard. Unitless (COMPAT) keeps both.
#
# Needs Python 3.13, pip and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3.13}" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet bpy==5.3.0
cat > "$work/write.py" <<'PY'
import bpy
import json
import math
import sys

bpy.ops.wm.read_factory_settings(use_empty=True)
lamp = bpy.data.lights.new("lamp", "POINT")
lamp.energy = 4 * math.pi
bpy.context.collection.objects.link(bpy.data.objects.new("lamp", lamp))
bpy.ops.mesh.primitive_plane_add()
material = bpy.data.materials.new("surface")
material.use_nodes = True
node = material.node_tree.nodes["Principled BSDF"]
node.inputs["Emission Color"].default_value = (1, 1, 1, 1)
node.inputs["Emission Strength"].default_value = 1
bpy.context.object.data.materials.append(material)
for mode in ("SPEC", "COMPAT"):
    path = f"{sys.argv[1]}/{mode}.gltf"
    bpy.ops.export_scene.gltf(filepath=path, export_format="GLTF_SEPARATE", export_lights=True,
                              export_import_convert_lighting_mode=mode)
    file = json.load(open(path))
    light = file["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"]
    strength = file["materials"][0].get("extensions", {}).get("KHR_materials_emissive_strength", {})
    print(f"found {mode}: lamp {light:.0f}, surface {strength.get('emissiveStrength', 1):.0f}")
PY
seen=$("$work/venv/bin/python" "$work/write.py" "$work" 2> /dev/null | sed -n 's/^found //p')
echo "$seen"
# As seen with bpy 5.3.0.
expected='SPEC: lamp 683, surface 1
COMPAT: lamp 1, surface 1'
[ "$seen" = "$expected" ] || { echo "the behaviour has changed" >&2; exit 1; }
