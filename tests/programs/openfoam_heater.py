"""OpenFOAM's tutorial multiRegionHeaterRadiation, a heated solid between two rooms of air, runs with our
files in the place of those of its own `viewFactorsGen`, and everything else as it is. Needs v1912 and
its examples (Debian: openfoam, openfoam-examples; FOAM_EXAMPLES names another folder of them)."""

import glob
import gzip
import os
import re
import shutil

from common import azulejo, check, folder, need, skip
from foam import patch_lengths, patch_values, row_sums, run

EXAMPLES = os.environ.get("FOAM_EXAMPLES", "/usr/share/doc/openfoam-examples/examples")
TUTORIAL = os.path.join(EXAMPLES, "heatTransfer/chtMultiRegionSimpleFoam/multiRegionHeaterRadiation")
AIR = ["bottomAir", "topAir"]
SOLID = ["heater", "leftSolid", "rightSolid"]
STEPS = 300
# Rows of its own factors add up to as much as 1.14, which `smoothing` scales to 1, and one row has many
# faces: mean fluxes differ by per cents.
TOLERATED = 0.02


def unpack(place):
    """Debian packs some of the files."""
    for path in glob.glob(os.path.join(place, "**/*.gz"), recursive=True):
        with gzip.open(path) as packed, open(path[:-3], "wb") as out:
            shutil.copyfileobj(packed, out)


def make_case():
    """What the tutorial's Allrun does before its factors, with fewer steps."""
    place = os.path.join(folder(), "case")
    shutil.copytree(TUTORIAL, place, symlinks=True)
    unpack(place)
    control = os.path.join(place, "system/controlDict")
    text = re.sub(r"(?m)^endTime .*", f"endTime {STEPS};", open(control).read())
    with open(control, "w") as out:
        out.write(re.sub(r"(?m)^writeInterval .*", f"writeInterval {STEPS};", text))
    run("blockMesh", place)
    run("topoSet", place)
    shutil.copytree(os.path.join(place, "0.orig"), os.path.join(place, "0"))
    run("splitMeshRegions", place, "-cellZones", "-overwrite")
    for region in SOLID:
        for name in "rho nut alphat epsilon k U p_rgh qr G IDefault".split():
            path = os.path.join(place, "0", region, name)
            if os.path.exists(path):
                os.remove(path)
    for region in AIR + SOLID:
        run("changeDictionary", place, "-region", region)
    return place


def own_factors(place):
    for region in AIR:
        run("faceAgglomerate", place, "-region", region, "-dict", "constant/viewFactorsDict")
        run("viewFactorsGen", place, "-region", region)


def our_factors(place):
    for region in AIR:
        here = os.path.join(place, "constant", region)
        azulejo("form-factors", os.path.join(here, "polyMesh/boundary"), "-o", here, "--format", "openfoam",
                "--openfoam", "v1912", "--by", "face", "--patch-size", "0", "--closure",
                "--tolerance", "1e-6")  # fmt: skip


def means(place):
    """Row sums by region, and mean qr by region and patch."""
    sums, fluxes = {}, {}
    run("chtMultiRegionSimpleFoam", place)
    for region in AIR:
        here = os.path.join(place, "constant", region)
        sums[region] = row_sums(os.path.join(here, "F"))
        values = patch_values(os.path.join(place, str(STEPS), region, "qr"), patch_lengths(here))
        fluxes.update({(region, p): sum(v) / len(v) for p, v in values.items()})
    return sums, fluxes


def main():
    ours = make_case()
    theirs = os.path.join(os.path.dirname(ours), "own")
    shutil.copytree(ours, theirs, symlinks=True)
    our_factors(ours)
    own_factors(theirs)
    (sums, fluxes), (own_sums, own_fluxes) = means(ours), means(theirs)
    for region in AIR:
        own = own_sums[region]
        print(f"{region}: {len(own)} rows of viewFactorsGen, whose sums are {min(own):.4f} to {max(own):.4f}")
        check(f"{region}: {len(sums[region])} rows, largest error of a sum",
              max(abs(s - 1) for s in sums[region]), 0.0, 1e-9)  # fmt: skip
    largest = max(map(abs, fluxes.values()))
    print(f"{'mean qr after ' + str(STEPS) + ' steps, W/m²':40} {'ours':>10} {'its own':>10}")
    for (region, patch), flux in fluxes.items():
        print(f"{region + ' ' + patch:40} {flux:10.4f} {own_fluxes[region, patch]:10.4f}")
    worst = max(abs(flux - own_fluxes[at]) for at, flux in fluxes.items())
    check("largest difference, share of the largest flux", worst / largest, 0.0, TOLERATED)


need("chtMultiRegionSimpleFoam", "apt-get install openfoam")
if not os.path.isdir(TUTORIAL):
    skip(f"{TUTORIAL} is missing (apt-get install openfoam-examples)")
main()
