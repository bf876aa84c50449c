"""Shares of the sky by patches, times the sky vectors of Radiance's gendaymtx: open level ground gets the diffuse
irradiance that the weather gives, and it and two walls get the sun from where it stands. Needs gendaymtx, of Radiance
or of pyradiance, and NumPy."""

import importlib.util
import math
import os
import shutil
import subprocess

from common import azulejo, check, folder, skip, write_obj

try:
    import numpy as np
except ImportError:
    skip("NumPy is missing (pip install numpy)")

LATITUDE = 40.0
# Month, day, hour, day of the year; direct normal and diffuse horizontal irradiance, W/m².
HOURS = [(6, 21, 8.0, 172, 600.0, 150.0), (12, 21, 14.0, 355, 300.0, 90.0), (6, 21, 16.0, 172, 500.0, 120.0)]
GROUND = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
# Far away, so that nothing is in the way.
WALLS = {
    "east": [(900, 0, 0), (900, 1, 0), (900, 1, 1), (900, 0, 1)],
    "south": [(0, -900, 0), (1, -900, 0), (1, -900, 1), (0, -900, 1)],
}


def gendaymtx():
    """The program, on the path or in the package."""
    found = shutil.which("gendaymtx")
    package = importlib.util.find_spec("pyradiance")
    if found is None and package is not None:
        root = os.path.dirname(package.origin)
        found = os.path.join(root, "bin", "gendaymtx")
        os.environ.setdefault("RAYPATH", os.path.join(root, "lib"))
    if found is None:
        skip("gendaymtx is missing (Radiance, or pip install pyradiance)")
    return found


def sun(day, hour):
    """Where Radiance has the sun on the meridian of its time zone: east, north, up."""
    declination = 0.4093 * math.sin(2 * math.pi / 368 * (day - 81))
    solar = (
        hour
        + 0.170 * math.sin(4 * math.pi / 373 * (day - 80))
        - 0.129 * math.sin(2 * math.pi / 355 * (day - 8))
    )
    turn, latitude = solar * math.pi / 12, math.radians(LATITUDE)
    up = math.sin(latitude) * math.sin(declination) - math.cos(latitude) * math.cos(declination) * math.cos(turn)
    east = math.cos(declination) * math.sin(turn)
    north = math.cos(latitude) * math.sin(declination) + math.sin(latitude) * math.cos(declination) * math.cos(turn)
    return np.array([east, north, up])


def sky_vectors(program, path, subdivisions, *options):
    """Radiances by patch and hour, of the green channel."""
    command = [program, "-m", str(subdivisions), "-O1", "-h", "-c", "1", "1", "1", "-g", "0", "0", "0", *options, path]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    lines = [line.split() for line in text.splitlines() if line.strip()]
    return np.array(lines, dtype=float)[:, 1].reshape(-1, len(HOURS))


def main():
    program, where = gendaymtx(), folder()
    weather, model = os.path.join(where, "hours.wea"), os.path.join(where, "open.obj")
    with open(weather, "w") as out:
        out.write(f"place somewhere\nlatitude {LATITUDE}\nlongitude 0\ntime_zone 0\n")
        out.write("site_elevation 0\nweather_data_file_units 1\n")
        out.writelines(f"{m} {d} {h} {direct} {diffuse}\n" for m, d, h, _, direct, diffuse in HOURS)
    write_obj(model, {"ground": [GROUND], **{name: [wall] for name, wall in WALLS.items()}})
    normals = {"ground": (0, 0, 1), "east": (1, 0, 0), "south": (0, -1, 0)}
    for subdivisions in (1, 2, 4):
        matrix = os.path.join(where, f"f{subdivisions}.npz")
        azulejo(
            *("form-factors", model, "--place", f"{model}:up=z", "--up", "z", "--patch-size", 0),
            *("--by", "object", "--sky-patches", f"reinhart:{subdivisions}", "-o", matrix),
        )
        factors = np.load(matrix)
        shares, directions = factors["sky_patches"], factors["sky_directions"]
        rows = {name: row for row, name in enumerate(factors["names"])}
        check(f"columns of {subdivisions}", np.abs(shares[:, 1:].sum(1) - factors["sky"]).max(), 0.0, 1e-6)
        grey = sky_vectors(program, weather, subdivisions, "-s")
        both = sky_vectors(program, weather, subdivisions)
        for hour, (_, _, time, day, direct, diffuse) in enumerate(HOURS):
            said = f"-m {subdivisions}, {time} o'clock"
            from_sky = math.pi * shares[rows["ground"]] @ grey[:, hour]
            check(f"{said}: sky on the ground", from_sky, diffuse, 0.02 * diffuse)
            for name, row in rows.items():
                # The sun is divided among the patches around it, which are as wide as 12, 6 or 3 degrees.
                from_sun = math.pi * shares[row] @ (both - grey)[:, hour]
                due = direct * max(0.0, float(np.dot(normals[name], sun(day, time))))
                check(f"{said}: sun on {name}", from_sun, due, 0.16 / subdivisions * direct)
        # The patch of the sun alone lies where the sun stands.
        suns = sky_vectors(program, weather, subdivisions, "-5", "0.533") - grey
        for hour, (_, _, time, day, *_) in enumerate(HOURS):
            patch = int(np.argmax(suns[:, hour]))
            apart = math.degrees(math.acos(min(1.0, float(directions[patch] @ sun(day, time)))))
            check(f"-m {subdivisions}, {time} o'clock: patch of the sun", apart, 0.0, 9.0 / subdivisions)


main()
