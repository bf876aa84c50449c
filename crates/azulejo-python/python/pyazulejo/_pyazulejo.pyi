"""The compiled half of pyazulejo: use the package, not this."""

from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "AzulejoError",
    "NativeCompressedFactors",
    "NativeFormFactors",
    "NativeLightmap",
    "NativeMaterials",
    "NativeScene",
    "NativeThermalSolution",
    "__version__",
    "bake_lightmap",
    "band_fractions",
    "compute_compressed_factors",
    "compute_form_factors",
    "compute_point_factors",
    "evaluate_brdf",
    "foreign_form_factors",
    "load_compressed_factors",
    "load_form_factors",
    "load_scene",
    "probe_irradiance",
    "render_image",
    "save_form_factors",
    "solve_exchange",
    "solve_light",
    "tone_map",
]
__version__: str

_Floats = NDArray[np.float64]
_Texels = NDArray[np.float32]
_SkyArrays = tuple[NDArray[np.float32], NDArray[np.float32], _Floats, _Floats, str]
_Colour = tuple[float, float, float]
_Material = tuple[str, _Colour, _Colour, _Colour, bool, str | None]
_Mesh = tuple[str, _Floats, NDArray[np.uint32], NDArray[np.uint32], int]

class AzulejoError(ValueError): ...

@final
class NativeScene:
    @staticmethod
    def from_meshes(
        meshes: list[_Mesh],
        materials: list[_Material],
        sky: _Colour | None,
        sun: tuple[_Colour, _Colour] | None,
        up: str,
        unit: float | None,
    ) -> NativeScene: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def areas(self) -> _Floats: ...
    @property
    def faces(self) -> NDArray[np.int64]: ...
    @property
    def materials(self) -> list[Any]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def is_solved(self) -> bool: ...
    @property
    def up(self) -> str: ...
    @property
    def unit(self) -> float | None: ...
    @property
    def bounds(self) -> _Floats: ...
    def html(self, words: tuple[str, str], most: int | None) -> str: ...
    def mesh(
        self, object: int
    ) -> tuple[_Floats, NDArray[np.uint32], NDArray[np.uint32], _Floats | None, _Floats | None]: ...

@final
class NativeFormFactors:
    def __len__(self) -> int: ...
    def csr(self) -> tuple[_Floats, NDArray[np.float32], NDArray[Any], NDArray[Any]]: ...
    def order(self, order: int) -> tuple[_Floats, NDArray[np.float32]]: ...
    def get(self, row: int, column: int) -> tuple[float, float]: ...
    def grouped(self, groups: NDArray[np.int64], names: list[str]) -> NativeFormFactors: ...
    def grouped_by(self, by: str) -> NativeFormFactors: ...
    def clustered(self, count: int, angle: float, whole_faces: bool) -> NativeFormFactors: ...
    def close(self, threads: int | None, progress: Any) -> NativeFormFactors: ...
    def truncate(self, share: float, threads: int | None, progress: Any) -> NativeFormFactors: ...
    def share(self, name: str) -> _Floats: ...
    @property
    def names(self) -> list[str] | None: ...
    @property
    def geometry(self) -> tuple[_Floats, NDArray[np.int64], _Floats, _Floats] | None: ...
    @property
    def areas(self) -> _Floats: ...
    @property
    def row_error(self) -> _Floats: ...
    @property
    def outside(self) -> list[_Floats] | None: ...
    @property
    def sky_patches(self) -> _SkyArrays | None: ...
    @property
    def ends(self) -> _Floats: ...
    @property
    def pieces(self) -> list[NDArray[Any]]: ...
    @property
    def engine(self) -> tuple[str, str, list[str]]: ...
    @property
    def is_closed(self) -> bool: ...
    @property
    def closed(self) -> list[float] | None: ...
    @property
    def truncated(self) -> list[float] | None: ...
    @property
    def rays(self) -> int: ...

@final
class NativeCompressedFactors:
    def __len__(self) -> int: ...
    @property
    def rows(self) -> NativeFormFactors: ...
    def products(self, x: _Floats, transposed: bool) -> _Floats: ...
    def product_with_errors(self, x: list[float]) -> tuple[_Floats, _Floats]: ...
    @property
    def stated(self) -> list[float]: ...
    @property
    def traced_again(self) -> int: ...
    @property
    def bytes(self) -> tuple[int, int]: ...
    @property
    def blocks(self) -> list[int]: ...
    def save(self, path: str | PathLike[str]) -> None: ...

@final
class NativeMaterials:
    @staticmethod
    def read(path: str | PathLike[str]) -> NativeMaterials: ...
    @staticmethod
    def from_numbers(records: list[tuple[str, list[tuple[str, float]]]]) -> NativeMaterials: ...
    @property
    def bands(self) -> list[str]: ...
    def paint(self, scene: NativeScene) -> NativeScene: ...

@final
class NativeLightmap:
    @property
    def pages(self) -> list[tuple[_Texels, _Texels, _Texels]]: ...
    @property
    def report(self) -> dict[str, Any]: ...
    def html(self, words: tuple[str, str], most: int | None) -> str: ...
    def save(
        self, path: str | PathLike[str], is_page: bool, words: tuple[str, str]
    ) -> list[str]: ...

@final
class NativeThermalSolution:
    @property
    def notes(self) -> list[str]: ...
    @property
    def bands(self) -> list[str]: ...
    def network(self, band: int) -> dict[str, Any]: ...
    def matrix(self, band: int, name: str) -> _Floats: ...
    @property
    def node_names(self) -> list[str]: ...
    @property
    def row_names(self) -> list[str]: ...
    @property
    def node_areas(self) -> _Floats: ...
    @property
    def row_areas(self) -> _Floats: ...
    @property
    def row_nodes(self) -> NDArray[np.int64]: ...
    def heat(self, name: str) -> _Floats: ...
    @property
    def iterations(self) -> int: ...
    @property
    def imbalance(self) -> float: ...
    @property
    def cells(
        self,
    ) -> tuple[_Floats, NDArray[np.uint32], NDArray[np.uint32], NDArray[np.uint32]] | None: ...
    def save(self, path: str | PathLike[str], args: dict[str, Any]) -> None: ...

def solve_exchange(
    factors: list[NativeFormFactors],
    materials: NativeMaterials,
    conditions: dict[str, Any] | None,
    args: dict[str, Any],
    threads: int | None,
    progress: Any,
) -> NativeThermalSolution: ...
def band_fractions(products: _Floats) -> _Floats: ...
def save_form_factors(
    factors: NativeFormFactors, path: str | PathLike[str], options: dict[str, Any]
) -> tuple[list[str], list[str]]: ...
def load_compressed_factors(
    path: str | PathLike[str], memory: int | None
) -> NativeCompressedFactors: ...
def load_form_factors(
    path: str | PathLike[str], memory: int | None
) -> tuple[NativeFormFactors, float]: ...
def foreign_form_factors(
    starts: NDArray[np.int64],
    columns: NDArray[np.int64],
    values: _Floats,
    areas: _Floats,
    mirrors: _Floats,
    sky: _Floats,
    names: list[str],
    unit: float | None,
) -> tuple[NativeFormFactors, float]: ...
def compute_point_factors(
    scene: NativeScene,
    points: _Floats,
    normals: _Floats | None,
    by: str,
    options: dict[str, Any],
    threads: int | None,
    progress: Any,
) -> tuple[
    tuple[_Floats, _Floats, NDArray[np.int64], NDArray[np.int64]],
    list[str] | None,
    int,
    list[_Floats],
    _SkyArrays | None,
]: ...
def load_scene(
    path: str | PathLike[str],
    unit: float | None,
    up: str | None,
    lod: str | float,
    allow: list[str | PathLike[str]],
    keep_light: bool,
    threads: int | None,
    progress: Any,
) -> NativeScene: ...
def compute_compressed_factors(
    scene: NativeScene,
    compress: float,
    options: dict[str, Any],
    threads: int | None,
    progress: Any,
) -> tuple[NativeCompressedFactors, list[str]]: ...
def compute_form_factors(
    scene: NativeScene,
    by: str,
    options: dict[str, Any],
    threads: int | None,
    progress: Any,
) -> tuple[NativeFormFactors, list[str]]: ...
def bake_lightmap(
    scene: NativeScene,
    texels: dict[str, Any],
    light: dict[str, Any],
    threads: int | None,
    progress: Any,
) -> NativeLightmap: ...
def solve_light(
    scene: NativeScene,
    options: dict[str, Any],
    threads: int | None,
    progress: Any,
) -> tuple[NativeScene, dict[str, Any]]: ...
def probe_irradiance(
    scene: NativeScene,
    points: _Floats,
    normals: _Floats,
    options: dict[str, Any],
    threads: int | None,
    progress: Any,
) -> tuple[_Floats, _Floats, dict[str, Any]]: ...
def render_image(
    scene: NativeScene,
    camera: dict[str, Any],
    how: dict[str, Any],
    threads: int | None,
    progress: Any,
) -> NDArray[np.float32]: ...
def tone_map(
    radiance: NDArray[np.float32], exposure: float | None, tone: str
) -> NDArray[np.uint8]: ...
def evaluate_brdf(
    text: str,
    wi: _Floats,
    wo: _Floats,
    quantity: str,
    threads: int | None,
) -> _Floats: ...
