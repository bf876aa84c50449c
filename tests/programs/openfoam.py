"""OpenFOAM's solver reads our files: a cube of 24 faces, floor 500 K, ceiling 300 K, walls 400 K, as
text and in binary, with rows in another order, with permuted numbers of clusters, with whole patches
as rows, with a patch that bends around an edge, and with clusters of faces, also around the corners of
walls that are one patch. Needs v1912 (Debian: openfoam)."""

import os
import re
import shutil

from common import SIGMA, azulejo, check, folder, grey_fluxes, need, read_mtx, write_obj
from foam import SIGMA_OF_OPENFOAM, patch_values, run

PATCHES = {"floor": "(0 3 2 1)", "ceiling": "(4 5 6 7)", "south": "(0 1 5 4)", "north": "(3 7 6 2)",
           "west": "(0 4 7 3)", "east": "(1 2 6 5)"}  # fmt: skip
# The walls as one patch, which closes around the room.
RING = {"floor": "(0 3 2 1)", "ceiling": "(4 5 6 7)", "walls": "(0 1 5 4) (3 7 6 2) (0 4 7 3) (1 2 6 5)"}
TEMPERATURE = {"floor": 500.0, "ceiling": 300.0}
WALL = 400.0
# Mean flux from floor and ceiling with 24 rows of exact factors, in W/m².
KNOWN = {"floor": 1748.98848079808, "ceiling": -1071.91903878795}
EPS = 0.8
COMMON = ["--patch-size", "0", "--engine", "analytic", "--closure"]


def header(kind, name):
    return f"FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"


def put(place, name, text, kind="dictionary"):
    path = os.path.join(place, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as out:
        out.write(header(kind, os.path.basename(name)) + text)


def temperature(patch):
    return TEMPERATURE.get(patch, WALL)


def field(patches, dimensions, inside, entry, kind):
    patches = "".join(f"  {p} {{ {entry(p)} }}\n" for p in patches)
    return f"dimensions {dimensions};\ninternalField uniform {inside};\nboundaryField\n{{\n{patches}}}\n", kind


def make_case(place, patches):
    """A cube whose patches have these faces."""
    corners = "(0 0 0) (1 0 0) (1 1 0) (0 1 0) (0 0 1) (1 0 1) (1 1 1) (0 1 1)"
    walls = "".join(f"  {p} {{ type wall; inGroups (wall viewFactorWall); faces ({f}); }}\n"
                    for p, f in patches.items())  # fmt: skip
    put(place, "system/blockMeshDict", f"convertToMeters 1;\nvertices ({corners});\nblocks (hex "
        f"(0 1 2 3 4 5 6 7) (2 2 2) simpleGrading (1 1 1));\nboundary\n(\n{walls});\n")  # fmt: skip
    put(place, "system/controlDict", "application buoyantSimpleFoam; startFrom startTime; startTime 0; "
        "stopAt endTime; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1; "
        "writeFormat ascii; writePrecision 14; writeCompression off; timePrecision 6;\n")  # fmt: skip
    put(place, "system/fvSchemes", "ddtSchemes { default steadyState; } gradSchemes { default Gauss "
        "linear; } divSchemes { default bounded Gauss upwind; div(((rho*nuEff)*dev2(T(grad(U))))) "
        "Gauss linear; } laplacianSchemes { default Gauss linear corrected; } interpolationSchemes "
        "{ default linear; } snGradSchemes { default corrected; }\n")  # fmt: skip
    put(place, "system/fvSolution", "solvers { p_rgh { solver PCG; preconditioner DIC; tolerance 1e-9; "
        'relTol 0.1; } ".*" { solver PBiCGStab; preconditioner DILU; tolerance 1e-9; relTol 0.1; } } '
        "SIMPLE { nNonOrthogonalCorrectors 0; pRefCell 0; pRefValue 0; }\n")  # fmt: skip
    put(place, "constant/g", "dimensions [0 1 -2 0 0 0 0]; value (0 0 0);\n", "uniformDimensionedVectorField")
    put(place, "constant/turbulenceProperties", "simulationType laminar;\n")
    put(place, "constant/thermophysicalProperties", "thermoType { type heRhoThermo; mixture pureMixture; "
        "transport const; thermo hConst; equationOfState perfectGas; specie specie; energy "
        "sensibleEnthalpy; } pRef 100000; mixture { specie { molWeight 28.9; } thermodynamics { Cp "
        "1000; Hf 0; } transport { mu 1.8e-05; Pr 0.7; } }\n")  # fmt: skip
    put(place, "constant/radiationProperties", "radiation on; radiationModel viewFactor; "
        "viewFactorCoeffs { smoothing false; constantEmissivity true; } solverFreq 1; "
        "absorptionEmissionModel none; scatterModel none; sootModel none; transmissivityModel none;\n")  # fmt: skip
    put(place, "constant/boundaryRadiationProperties", f'".*" {{ type lookup; emissivity {EPS}; '
        f"absorptivity {EPS}; transmissivity 0; }}\n")  # fmt: skip
    fields = {
        "T": field(patches, "[0 0 0 1 0 0 0]", 300, lambda p: f"type fixedValue; value uniform {temperature(p)};", "volScalarField"),
        "U": field(patches, "[0 1 -1 0 0 0 0]", "(0 0 0)", lambda p: "type noSlip;", "volVectorField"),
        "p": field(patches, "[1 -1 -2 0 0 0 0]", 1e5, lambda p: "type calculated; value uniform 1e5;", "volScalarField"),
        "p_rgh": field(patches, "[1 -1 -2 0 0 0 0]", 1e5, lambda p: "type fixedFluxPressure; value uniform 1e5;", "volScalarField"),
        "qr": field(patches, "[1 0 -3 0 0 0 0]", 0, lambda p: "type greyDiffusiveRadiationViewFactor; qro uniform 0; "
                    "emissivityMode lookup; value uniform 0;", "volScalarField"),
    }  # fmt: skip
    for name, (text, kind) in fields.items():
        put(place, f"0/{name}", text, kind)


def read_mesh(place):
    """Polygons by patch, turned to face the room: OpenFOAM's point out of it."""
    def body(name):
        text = open(os.path.join(place, "constant/polyMesh", name)).read()
        return re.sub(r"/\*.*?\*/|//[^\n]*|FoamFile\s*\{.*?\}", "", text, flags=re.S)

    points = [tuple(map(float, m.split())) for m in re.findall(r"\(([-0-9.e+ ]+)\)", body("points"))]
    faces = [list(map(int, m.split())) for m in re.findall(r"\d\(([0-9 ]+)\)", body("faces"))]
    patches = re.findall(r"(\w+)\s*\{[^}]*?nFaces\s+(\d+);\s*startFace\s+(\d+);", body("boundary"))
    polygon = lambda face: [points[c] for c in reversed(face)]
    return {n: [polygon(f) for f in faces[int(s):int(s) + int(k)]] for n, k, s in patches}


def examine(what, place, rows, factors):
    """Runs the solver and compares; rows are (patch, its faces)."""
    shutil.rmtree(os.path.join(place, "1"), ignore_errors=True)
    run("buoyantSimpleFoam", place)
    lengths = {}
    for patch, faces in rows:
        lengths[patch] = max(lengths.get(patch, 0), 1 + max(faces))
    found = patch_values(os.path.join(place, "1/qr"), lengths)
    expected = grey_fluxes(factors, [EPS] * len(rows), [temperature(p) for p, _ in rows], SIGMA_OF_OPENFOAM)
    worst = max(abs(found[p][k] + q) for (p, faces), q in zip(rows, expected) for k in faces)
    check(f"{what}: qr + q, W/m², largest", worst, 0.0, 1e-6)
    if len(rows) < 24:
        return
    for patch, known in KNOWN.items():
        mean = -sum(found[patch]) / 4 * SIGMA / SIGMA_OF_OPENFOAM
        check(f"{what}: flux from {patch}, W/m²,", mean, known, 1e-5)


def permute_clusters(place):
    """Gives clusters of a patch other numbers: rows stay, since their order is that of faces."""
    path = os.path.join(place, "constant/finalAgglom")
    text = open(path).read()
    permuted = text.replace("4(0 1 2 3)", "4(2 0 3 1)")
    if permuted == text:
        raise SystemExit(f"no patch of four clusters in {path}")
    with open(path, "w") as out:
        out.write(permuted)


def cube():
    place = folder()
    make_case(place, PATCHES)
    run("blockMesh", place)
    mesh = read_mesh(place)
    open(os.path.join(place, "case.foam"), "w").close()
    straight, turned = os.path.join(place, "cube.obj"), os.path.join(place, "turned.obj")
    write_obj(straight, mesh)
    write_obj(turned, dict(reversed(mesh.items())))
    mtx = os.path.join(place, "f.mtx")
    azulejo("form-factors", straight, "-o", mtx, *COMMON)
    factors = read_mtx(mtx)
    rows = [(p, [k]) for p in mesh for k in range(4)]
    for model, form in [(straight, "openfoam"), (straight, "openfoam-binary"), (turned, "openfoam")]:
        azulejo("form-factors", model, "-o", place, "--format", form, "--openfoam", "v1912", *COMMON)
        examine(f"{form}, {os.path.basename(model)}", place, rows, factors)
    permute_clusters(place)
    examine("permuted numbers of clusters", place, rows, factors)
    # The case itself as the model.
    azulejo("form-factors", os.path.join(place, "case.foam"), "-o", place, "--format", "openfoam",
            "--openfoam", "v1912", "--by", "face", *COMMON)  # fmt: skip
    examine("the case as the model", place, rows, factors)
    whole_patches("whole patches", place, mesh)


def bent():
    """Floor and east wall are one patch and one row, which sees itself."""
    place = folder()
    patches = {**PATCHES, "floor": f"{PATCHES['floor']} {PATCHES['east']}"}
    del patches["east"]
    make_case(place, patches)
    run("blockMesh", place)
    whole_patches("a bent cluster", place, read_mesh(place))


def whole_patches(what, place, mesh):
    model, mtx = os.path.join(place, "patches.obj"), os.path.join(place, "f.mtx")
    write_obj(model, mesh)
    grouped = [*COMMON, "--by", "object"]
    azulejo("form-factors", model, "-o", mtx, *grouped)
    azulejo("form-factors", model, "-o", place, "--format", "openfoam", "--openfoam", "v1912",
            *grouped)  # fmt: skip
    factors = read_mtx(mtx)
    own = [row[i] for i, row in enumerate(factors)]
    print(f"{what}: own factors {min(own):.6f} to {max(own):.6f}")
    examine(what, place, [(p, range(len(faces))) for p, faces in mesh.items()], factors)


def clusters(place, mesh):
    """The faces of each cluster with their patch, in the order of rows."""
    text = open(os.path.join(place, "constant/finalAgglom")).read()
    lists = re.findall(r"\d+\(([0-9 ]+)\)", text)
    rows = []
    for patch, numbers in zip(mesh, lists):
        numbers = [int(n) for n in numbers.split()]
        rows += [(patch, [k for k, n in enumerate(numbers) if n == c]) for c in range(max(numbers) + 1)]
    return rows


def examine_clusters(what, patches, options, expected):
    """Of the case, and of factors between its faces that were stored before."""
    place = folder()
    make_case(place, patches)
    run("blockMesh", place)
    mesh = read_mesh(place)
    case = os.path.join(place, "case.foam")
    open(case, "w").close()
    foam = ["-o", place, "--format", "openfoam", "--openfoam", "v1912"]
    stored, mtx = os.path.join(place, "f.npz"), os.path.join(place, "f.mtx")
    azulejo("form-factors", case, "-o", stored, *COMMON)
    azulejo("form-factors", stored, "-o", mtx, *options)
    for model, how in [(case, COMMON), (stored, [])]:
        azulejo("form-factors", model, *foam, *how, *options)
        rows = clusters(place, mesh)
        check(f"{what}, {os.path.basename(model)}: rows", len(rows), expected, 0)
        examine(f"{what}, {os.path.basename(model)}", place, rows, read_mtx(mtx))


need("buoyantSimpleFoam", "apt-get install openfoam")
cube()
bent()
examine_clusters("12 clusters", PATCHES, ["--cluster", "12"], 12)
# They bend around corners, but none closes the ring.
examine_clusters("bent clusters", RING, ["--cluster", "4", "--cluster-angle", "90"], 4)
