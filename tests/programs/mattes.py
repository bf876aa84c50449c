"""Cryptomatte: OpenImageIO finds the channels and attributes, and the coverages of a title are those of its picture. Needs the
Python packages OpenImageIO, mmh3 and numpy."""

import json
import os
import struct

from common import azulejo, check, folder, skip

try:
    import mmh3
    import numpy as np
    import OpenImageIO as oiio
except ImportError:
    skip("OpenImageIO, mmh3 or NumPy is missing (pip install OpenImageIO mmh3 numpy)")

HERE = os.path.dirname(os.path.abspath(__file__))
FONT = os.path.join(HERE, "../../examples/fonts/dejavu-serif.ppf")
place = folder()
model, image = os.path.join(place, "title.grf"), os.path.join(place, "title.exr")
azulejo("text", "Light", "--ppf", FONT, "--emission", "1", "--name", "title", "-o", model)
azulejo("render", model, "--from", "1,0.5,4", "--at", "1,0.3,0", "--fov", "40", "--size", "160x90", "--spp", "64",
        "--layers", "cryptomatte,glyph", "-o", image)  # fmt: skip


def id_of(name):
    """As the specification has it, by another implementation of the hash."""
    bits = mmh3.hash(name, 0, signed=False)
    exponent = bits >> 23 & 255
    if exponent in (0, 255):
        bits ^= 1 << 23
    return struct.unpack("<f", struct.pack("<I", bits))[0], bits


buffer = oiio.ImageBuf(image)
spec, pixels = buffer.spec(), np.asarray(buffer.get_pixels(oiio.FLOAT))
names = list(spec.channelnames)
attributes = {a.name: a.value for a in spec.extra_attribs}
for layer, things in {"CryptoObject": [f"title/{k + 1}" for k in range(5)], "CryptoAsset": ["title"],
                      "CryptoMaterial": ["title"]}.items():  # fmt: skip
    key = f"cryptomatte/{mmh3.hash(layer, 0, signed=False):08x}"[:19]
    check(f"{layer}: name", float(attributes[f"{key}/name"] == layer), 1, 0)
    check(f"{layer}: hash", float(attributes[f"{key}/hash"] == "MurmurHash3_32"), 1, 0)
    check(f"{layer}: conversion", float(attributes[f"{key}/conversion"] == "uint32_to_float32"), 1, 0)
    manifest = json.loads(attributes[f"{key}/manifest"])
    check(f"{layer}: names", float(sorted(manifest) == sorted(things)), 1, 0)
    ids = {}
    for name, text in manifest.items():
        value, bits = id_of(name)
        check(f"{layer}: id of {name}", float(int(text, 16)), float(bits), 0)
        ids[np.float32(value)] = name
    total, area = np.zeros(pixels.shape[:2]), dict.fromkeys(manifest, 0.0)
    for rank in range(6):
        group, letters = rank // 2, "rgba"[rank % 2 * 2:][:2]
        of_id, coverage = (pixels[:, :, names.index(f"{layer}{group:02}.{c}")] for c in letters)
        total += coverage
        for value in np.unique(of_id[coverage > 0]):
            area[ids[np.float32(value)]] += float(coverage[of_id == value].sum())
    check(f"{layer}: most coverage", float(total.max()), 1, 1e-6)
    # A lamp of radiance 1 on black: the picture is the coverage, by other samples.
    light = pixels[:, :, names.index("G")]
    check(f"{layer}: coverage by that of the picture", float(total.sum() / light.sum()), 1, 3e-3)
    check(f"{layer}: difference from the picture, RMS", float(np.sqrt(np.mean((total - light) ** 2))), 0, 0.02)
    check(f"{layer}: all seen", float(min(area.values()) > 10), 1, 0)
