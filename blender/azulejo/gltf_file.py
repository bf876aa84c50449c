# SPDX-License-Identifier: MIT OR Apache-2.0
"""As much of glTF as is needed to read texture coordinates back."""

import json
from pathlib import Path
from urllib.parse import unquote

import numpy

COMPONENTS = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class GltfFile:
    """A .gltf file with its buffers beside it."""

    def __init__(self, path: Path) -> None:
        """Reads the file."""
        self.json = json.loads(path.read_text("utf-8"))
        names = [unquote(buffer["uri"]) for buffer in self.json.get("buffers", [])]
        self.buffers = [(path.parent / name).read_bytes() for name in names]

    def array(self, index: int) -> numpy.ndarray:
        """The numbers of an accessor, one row for each element."""
        accessor = self.json["accessors"][index]
        if "sparse" in accessor or "bufferView" not in accessor:
            raise ValueError("sparse accessors are not expected here")
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind = numpy.dtype(COMPONENTS[accessor["componentType"]])
        width, count = WIDTHS[accessor["type"]], accessor["count"]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", 0) or kind.itemsize * width
        shape, strides = (count, width), (stride, kind.itemsize)
        rows = numpy.ndarray(shape, kind, self.buffers[view["buffer"]], start, strides).copy()
        if accessor.get("normalized"):
            rows = rows / numpy.iinfo(kind).max
        return rows
