#!/usr/bin/env bash
# raystrack 2.0.0: neighbouring seeds have the same random numbers. Replicate r of seed s uses the generator of s + r, so
# that the result of seed 1 with two replicates is the mean of those of seeds 1 and 2 with one each. With the default of
# up to 100 replicates, runs with seeds 1, 2, 3, ... share nearly all of their rays: eight of them scatter by 9e-5, and by
# 6e-4 with seeds that are 1,000 apart, and their mean is hardly better than one of them.
#
# Needs Python 3, pip and its registry. Fails if the behaviour changes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${PYTHON:-python3}" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet raystrack==2.0.0
cat > "$work/seeds.py" <<'PY'
import numpy as np
import raystrack

# Two unit squares that face each other at distance 1: 0.1998.
LOW = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
HIGH = np.array([(0.0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 0, 1)])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def factor(seed, replicates):
    options = raystrack.SolveOptions(
        sampling=raystrack.Sampling(density=64, rays_per_cell=16, seed=seed),
        accuracy=raystrack.Accuracy(min_replicates=replicates, max_replicates=replicates),
    )
    scene = raystrack.Scene.from_meshes({"a": raystrack.Mesh(LOW, TRIANGLES), "b": raystrack.Mesh(HIGH, TRIANGLES)})
    with raystrack.Solver(scene, device="cpu") as solver:
        result = solver.solve(raystrack.Query.matrix(receiver_sides=("front",)), options)
    column = {channel: k for k, channel in enumerate(result.channels)}
    return float(result.dense()[0, column[raystrack.Channel("surface", "b", "front")]])


one, two, both = factor(1, 1), factor(2, 1), factor(1, 2)
print(f"found seed 1: {one:.6f}, seed 2: {two:.6f}, their mean {(one + two) / 2:.6f}, seed 1 with two replicates {both:.6f}")
assert one != two and abs((one + two) / 2 - both) < 1e-12, "replicates of one seed are those of the next ones no longer"
near = np.std([factor(seed, 100) for seed in range(1, 9)])
far = np.std([factor(1000 * seed, 100) for seed in range(1, 9)])
print(f"found scatter of eight runs of 100 replicates: {near:.1e} with seeds 1 to 8, {far:.1e} with seeds 1,000 apart")
assert near < 0.5 * far, "neighbouring seeds scatter as much as distant ones"
PY
"$work/venv/bin/python" "$work/seeds.py"
