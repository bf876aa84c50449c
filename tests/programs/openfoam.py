"""OpenFOAM's solver reads our files: a cube of 24 faces, floor 500 K, ceiling 300 K, walls 400 K, as
text and in binary, with rows in another order, walls as whole patches, and clusters of faces, also around
the corners of walls that are one patch. Needs v1912 (Debian: openfoam)."""

import os
import re
import subprocess

from common import SIGMA, azulejo, check, folder, grey_fluxes, need, read_mtx, write_obj

PATCHES = {"floor": "(0 3 2 1)", "ceiling": "(4 5 6 7)", "south": "(0 1 5 4)", "north": "(3 7 6 2)",
           "west": "(0 4 7 3)", "east": "(1 2 6 5)"}  # fmt: skip
TEMPERATURE = {"floor": 500.0, "ceiling": 300.0}
WALL = 400.0
# The walls as one patch, which closes around the room.
RING = {"floor": "(0 3 2 1)", "ceiling": "(4 5 6 7)", "walls": "(0 1 5 4) (3 7 6 2) (0 4 7 3) (1 2 6 5)"}
# Mean flux from floor and ceiling with 24 rows of exact factors, in W/m².
KNOWN = {"floor": 1748.98848079808, "ceiling": -1071.91903878795}
EPS = 0.8
# OpenFOAM computes it from six digits of h, k and c.
SIGMA_OF_OPENFOAM = 5.67040856e-8


def header(kind, name):
    return f"FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"


def put(place, name, text, kind="dictionary"):
    path = os.path.join(place, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as out:
        out.write(header(kind, os.path.basename(name)) + text)


def temperature(patch):
    return TEMPERATURE.get(patch, WALL)


def field(names, dimensions, inside, entry, kind):
    patches = "".join(f"  {p} {{ {entry(p)} }}\n" for p in names)
    return f"dimensions {dimensions};\ninternalField uniform {inside};\nboundaryField\n{{\n{patches}}}\n", kind


def make_case(place, patches):
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


# Debian's package needs to be told where it is.
if os.path.isdir("/usr/share/openfoam"):
    os.environ.setdefault("WM_PROJECT_DIR", "/usr/share/openfoam")


def run(place, program):
    done = subprocess.run([program, "-case", place], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{program} failed in {place}:\n{done.stdout[-2500:]}\n{done.stderr[-2500:]}")


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


def fluxes(place, mesh):
    """qr by patch."""
    text = open(os.path.join(place, "1/qr")).read()
    found = {}
    for patch, faces in mesh.items():
        block = re.search(rf"\b{patch}\s*\{{(.*?)\}}", text, re.S).group(1)
        many = re.search(r"\bvalue\s+nonuniform List<scalar>\s*\d*\s*\((.*?)\)", block, re.S)
        one = re.search(r"\bvalue\s+uniform ([-0-9.e+]+)", block)
        found[patch] = [float(x) for x in many.group(1).split()] if many else [float(one.group(1))] * len(faces)
    return found


def examine(what, place, mesh, rows, factors):
    subprocess.run(["rm", "-rf", os.path.join(place, "1")], check=True)
    run(place, "buoyantSimpleFoam")
    found = fluxes(place, mesh)
    expected = grey_fluxes(factors, [EPS] * len(rows), [temperature(p) for p, _ in rows], SIGMA_OF_OPENFOAM)
    worst = max(abs(found[p][k] + q) for (p, faces), q in zip(rows, expected) for k in faces)
    check(f"{what}: qr + q, W/m², largest", worst, 0.0, 1e-6)
    if len(rows) < 24:
        return
    for patch, known in KNOWN.items():
        mean = -sum(found[patch]) / 4 * SIGMA / SIGMA_OF_OPENFOAM
        check(f"{what}: flux from {patch}, W/m²,", mean, known, 1e-5)


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
    run(place, "blockMesh")
    mesh = read_mesh(place)
    case = os.path.join(place, "case.foam")
    open(case, "w").close()
    common = ["--patch-size", "0", "--engine", "analytic", "--closure"]
    foam = ["-o", place, "--format", "openfoam", "--openfoam", "v1912"]
    stored, mtx = os.path.join(place, "f.npz"), os.path.join(place, "f.mtx")
    azulejo("form-factors", case, "-o", stored, *common)
    azulejo("form-factors", stored, "-o", mtx, *options)
    for model, how in [(case, common), (stored, [])]:
        azulejo("form-factors", model, *foam, *how, *options)
        rows = clusters(place, mesh)
        check(f"{what}, {os.path.basename(model)}: rows", len(rows), expected, 0)
        examine(f"{what}, {os.path.basename(model)}", place, mesh, rows, read_mtx(mtx))


def main():
    place = folder()
    make_case(place, PATCHES)
    run(place, "blockMesh")
    mesh = read_mesh(place)
    open(os.path.join(place, "case.foam"), "w").close()
    straight, turned = os.path.join(place, "cube.obj"), os.path.join(place, "turned.obj")
    write_obj(straight, mesh)
    write_obj(turned, dict(reversed(mesh.items())))
    common = ["--patch-size", "0", "--engine", "analytic", "--closure"]
    mtx = os.path.join(place, "f.mtx")
    azulejo("form-factors", straight, "-o", mtx, *common)
    factors = read_mtx(mtx)
    rows = [(p, [k]) for p in mesh for k in range(4)]
    for model, form in [(straight, "openfoam"), (straight, "openfoam-binary"), (turned, "openfoam")]:
        azulejo("form-factors", model, "-o", place, "--format", form, "--openfoam", "v1912", *common)
        examine(f"{form}, {os.path.basename(model)}", place, mesh, rows, factors)
    # The case itself as the model.
    azulejo("form-factors", os.path.join(place, "case.foam"), "-o", place, "--format", "openfoam",
            "--openfoam", "v1912", "--by", "face", *common)  # fmt: skip
    examine("the case as the model", place, mesh, rows, factors)
    # Whole patches.
    grouped = [*common, "--by", "object"]
    azulejo("form-factors", straight, "-o", mtx, *grouped)
    azulejo("form-factors", straight, "-o", place, "--format", "openfoam", "--openfoam", "v1912",
            *grouped)  # fmt: skip
    examine("whole patches", place, mesh, [(p, range(4)) for p in mesh], read_mtx(mtx))
    examine_clusters("12 clusters", PATCHES, ["--cluster", "12"], 12)
    # They bend around corners, but none closes the ring.
    examine_clusters("bent clusters", RING, ["--cluster", "4", "--cluster-angle", "90"], 4)


need("buoyantSimpleFoam", "apt-get install openfoam")
main()
