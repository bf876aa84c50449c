#!/usr/bin/env bash
# Blender 5.3.0: an image made by `images.new(float_buffer=True)`, whose colour space is said to be Linear Rec.709, is
# saved as EXR with values encoded as sRGB: 0.3 is 0.5838 in the file. Only the attribute colorInteropID of the header
# says so, "srgb_rec709_display"; programs that take EXR as linear read 0.5838. With the colour space Non-Color the file
# has 0.3.
#
# Needs Python 3.13, pip and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3.13}" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet bpy==5.3.0 OpenEXR==3.4.4 numpy==2.3.5
cat > "$work/write.py" <<'PY'
import bpy
import sys

bpy.ops.wm.read_factory_settings(use_empty=True)
for name in ("Linear Rec.709", "Non-Color"):
    image = bpy.data.images.new("made", 8, 4, float_buffer=True)
    print(f"found default: {image.colorspace_settings.name}")
    image.colorspace_settings.name = name
    image.pixels.foreach_set([0.3, 0.5, 1.0, 1.0] * 32)
    image.filepath_raw = f"{sys.argv[1]}/{name}.exr"
    image.file_format = "OPEN_EXR"
    image.save()
PY
cat > "$work/read.py" <<'PY'
import OpenEXR
import sys

for name in ("Linear Rec.709", "Non-Color"):
    with OpenEXR.File(f"{sys.argv[1]}/{name}.exr", separate_channels=True) as file:
        space = file.header().get("colorInteropID", "none")
        print(f"found {name}: {float(file.channels()['R'].pixels[0][0]):.2f}, {space}")
PY
run() { "$work/venv/bin/python" "$work/$1.py" "$work" 2> /dev/null; }
seen=$( { run write; run read; } | sed -n 's/^found //p' | sort -u)
echo "$seen"
# As seen with bpy 5.3.0.
expected='Linear Rec.709: 0.58, srgb_rec709_display
Non-Color: 0.30, data
default: Linear Rec.709'
[ "$seen" = "$expected" ] || { echo "the behaviour has changed" >&2; exit 1; }
