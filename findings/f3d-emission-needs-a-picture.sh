#!/usr/bin/env bash
# f3d 4.0.0 (glTF by VTK): a material of glTF emits emissiveFactor times its emissiveTexture, which is white if there is
# none, times emissiveStrength of KHR_materials_emissive_strength. Here a black square with emissiveFactor 0.5 is as black
# without an emissiveTexture as if it did not emit, and with one of a white pixel it is right; and a square with 0.125 and a
# strength of 4, which should look the same, has the brightness of 0.125.
#
# Needs Python 3.9 to 3.13, pip and its registry, and EGL (libegl1 with Mesa's drivers). Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3.13}" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet f3d==4.0.0
cat > "$work/show.py" <<'PY'
import base64
import json
import struct
import sys
import zlib

import f3d


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def uri(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


WHITE = (
    b"\x89PNG\r\n\x1a\n"
    + chunk(b"IHDR", struct.pack(">2I5B", 1, 1, 8, 2, 0, 0, 0))
    + chunk(b"IDAT", zlib.compress(b"\0\xff\xff\xff"))
    + chunk(b"IEND", b"")
)
POINTS = struct.pack("<12f", -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0)
UVS = struct.pack("<8f", 0, 0, 1, 0, 1, 1, 0, 1)
CORNERS = struct.pack("<6H", 0, 1, 2, 0, 2, 3)


def squares(has_picture: bool) -> dict:
    """A square of emission 0.5, and to its right one of 0.125 with a strength of 4."""

    def material(factor: float, strength: float) -> dict:
        return {
            "emissiveFactor": [factor] * 3,
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}},
            **({"emissiveTexture": {"index": 0}} if has_picture else {}),
        }

    def mesh(k: int) -> dict:
        return {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": k}]}

    ends = {"min": [-1, -1, 0], "max": [1, 1, 0]}
    return {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "translation": [-1.5, 0, 0]}, {"mesh": 1, "translation": [1.5, 0, 0]}],
        "meshes": [mesh(0), mesh(1)],
        "materials": [material(0.5, 1), material(0.125, 4)],
        "images": [{"uri": uri("image/png", WHITE)}],
        "textures": [{"source": 0}],
        "buffers": [{"byteLength": 92, "uri": uri("application/octet-stream", POINTS + UVS + CORNERS)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 12},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", **ends},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
    }


f3d.Engine.autoload_plugins()
for has_picture in (False, True):
    path = f"{sys.argv[1]}/squares.gltf"
    with open(path, "w") as out:
        json.dump(squares(has_picture), out)
    engine = f3d.Engine.create(offscreen=True)
    engine.options.update({"render.grid.enable": False, "render.background.color": [0, 0, 0]})
    engine.window.size = (200, 100)
    engine.scene.add(path)
    camera = engine.window.camera
    camera.position, camera.focal_point = (0, 0, 8), (0, 0, 0)
    image = engine.window.render_to_image()
    level = [image.content[(50 * image.width + x) * image.channel_count] for x in (65, 135)]
    print(f"found {'a white picture' if has_picture else 'no picture'}: {level[0]} and {level[1]} of 255")
PY
"$work/venv/bin/python" "$work/show.py" "$work" 2> /dev/null | grep -a -o 'found .*' | tee "$work/found"
# As seen with f3d 4.0.0, to a few levels: 0.5 is 188 in sRGB, and 0.125 is 99.
numbers=$(sed -E 's/.*: ([0-9]+) and ([0-9]+) of 255/\1 \2/' "$work/found" | tr '\n' ' ')
read -r plain strong pictured strong_pictured <<< "$numbers"
near() { [ $(($1 - $2)) -ge -4 ] && [ $(($1 - $2)) -le 4 ]; }
if ! { near "$plain" 18 && near "$strong" 18 && near "$pictured" 187 && near "$strong_pictured" 100; }; then
    echo "the behaviour has changed" >&2
    exit 1
fi
