#!/usr/bin/env python3
"""What `bake --denoise` leaves of noise, and what `bake --directional` costs: the tables of BENCHMARKS.md.

    python3 tests/programs/lightmap_noise.py AZULEJO SIZE MODEL [OPTION...]

Bakes MODEL with N, N/4 and N/4 filtered rays a texel (N = 256) and with 4096 rays as the truth, and prints root mean
squares of what irradiance is off by, over the mean; then CPU seconds to 2% with and without directions, medians of
three. Takes minutes. Needs NumPy and OpenEXR (pip).
"""

import os
import resource
import statistics
import subprocess
import sys
import tempfile

import numpy
import OpenEXR

TRUTH, RAYS = 4096, 256


def cpu_seconds(command):
    """Runs a command and returns what it and its children took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(azulejo, size, model, *options):
    with tempfile.TemporaryDirectory() as folder:
        output = os.path.join(folder, "baked.glb")
        bake = [azulejo, "bake", model, "-o", output, "--size", size, *options]

        def irradiance(rays, seed, *more):
            picture = os.path.join(folder, "e.exr")
            more = ["--rays", str(rays), "--seed", str(seed), "--float", "--lightmap", picture, *more]
            seconds = cpu_seconds(bake + more)
            channels = OpenEXR.File(picture, separate_channels=True).channels()
            return numpy.stack([channels[c].pixels for c in "RGB"]).astype(float), seconds

        truth, _ = irradiance(TRUTH, 1)
        is_lit = truth.sum(axis=0) > 0
        mean = truth[:, is_lit].mean()
        for name, rays, more in [
            ("all rays", RAYS, []),
            ("a quarter", RAYS // 4, []),
            ("a quarter, filtered", RAYS // 4, ["--denoise"]),
        ]:
            found, seconds = irradiance(rays, 7, *more)
            off = (found - truth)[:, is_lit]
            rms, bias = numpy.sqrt((off**2).mean()) / mean, off.mean() / mean
            print(f"{name:20} {rays:5} rays  rms {rms:.2%}  bias {bias:+.2%}  {seconds:.1f} CPU s", flush=True)
        for more in [[], ["--directional"]]:
            times = [cpu_seconds(bake + ["--error", "2%", *more]) for _ in range(3)]
            print(f"to 2% {' '.join(more):14} {statistics.median(times):.2f} CPU s", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
