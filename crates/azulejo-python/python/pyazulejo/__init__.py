"""Form factors, radiative exchange, light and reflection models as NumPy arrays.

>>> import numpy as np, pyazulejo as az
>>> def square(z, up):
...     v = np.array([[0, 0, z], [1, 0, z], [1, 1, z], [0, 1, z]])
...     return v, np.array([[0, 1, 2, 3] if up else [3, 2, 1, 0]])
>>> scene = az.Scene({"floor": square(0, True), "lid": square(1, False)}, up="z")
>>> f = az.form_factors(scene, by="object", patch_size=0)
>>> round(f["floor", "lid"], 9)
0.199824896

Lengths are in the scene's units, light is in W/m² and W/(sr·m²) as linear red, green and blue.
Results do not depend on the number of threads: the same seed gives the same bits, which are those of
the command ``azulejo``. Long calls release the interpreter, end on Ctrl-C, and report their progress.
"""

from ._brdf import brdf, directions
from ._compressed import CompressedFactors
from ._exchange import Exchange, band_fraction, exchange
from ._form_factors import Factor, FormFactors, form_factors
from ._light import Irradiance, probe, render, solve_light, tone_map
from ._lightmap import Lightmap, LightmapPage, bake
from ._materials import Material
from ._page import show
from ._points import PointFactors, point_factors
from ._pyazulejo import AzulejoError, __version__
from ._radiosity import NodeHeat, Radiosity, radiosity
from ._rows import SkyPatches
from ._scene import MeshArrays, Scene, load

__all__ = [
    "AzulejoError",
    "CompressedFactors",
    "Exchange",
    "Factor",
    "FormFactors",
    "Irradiance",
    "Lightmap",
    "LightmapPage",
    "Material",
    "MeshArrays",
    "NodeHeat",
    "PointFactors",
    "Radiosity",
    "Scene",
    "SkyPatches",
    "__version__",
    "bake",
    "band_fraction",
    "brdf",
    "directions",
    "exchange",
    "form_factors",
    "load",
    "point_factors",
    "probe",
    "radiosity",
    "render",
    "show",
    "solve_light",
    "tone_map",
]
