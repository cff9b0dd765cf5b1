# SPDX-License-Identifier: MIT
"""A slab is cut, sewn by stitches and pulled; draws the gap of the wound over the pull, with stitches and without."""

import argparse

import matplotlib
import numpy as np

import phymul

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

parser = argparse.ArgumentParser(prog="sewn_cut.py", description=__doc__)
parser.add_argument("--out", default="sewn_cut.png", help="the picture")
parser.add_argument("--quick", action="store_true", help="fewer ticks")
arguments = parser.parse_args()

size = np.array((0.06, 0.03, 0.01))
slab = phymul.make_tetrahedral_block(size, 18, 9, 3)
slab.set_material(young=10e3, poisson=0.45, density=1000)
middle, ticks = size[0] / 2, 60 if arguments.quick else 300
bottom = 0.4 * size[2]  # of the cut, from above


def pulled(stitches):
    """mm: the gap at the top, tick by tick; and the sim."""
    sim = phymul.Simulation(slab.with_spare_particles(200), damping=60)
    assert sim.cut((middle, 0, 0), (1, 0, 0), front=((0, 0, bottom), (0, 0, -1)))
    along = np.linspace(0.1, 0.9, 9) * size[1]
    lips = [sim.bind([(middle + side, y, size[2]) for y in along]) for side in (-1e-4, 1e-4)]
    threads = []
    for y in (np.arange(stitches) + 0.5) / max(stitches, 1) * size[1]:
        places = [(middle + x, y, z) for x, z in ((-0.005, 0.009), (-0.002, 0.005), (0.002, 0.005), (0.005, 0.009))]
        threads.append(sim.sew(phymul.Thread(length=0.08, throw_holding=2.0), places))
        threads[-1].tie(0, 3, throws=4)
    sim.fix("x0").add_load("translation", "x1", (1, 0, 0), [(0, 0), (0.3, 0.009)])
    gaps = []
    for _ in range(ticks):
        sim.advance(0.3 / ticks)
        left, right = (lip.deform()[0] for lip in lips)
        gaps.append(1e3 * (right - left)[:, 0].mean())
    return sim, threads, np.array(gaps)


pulls = np.linspace(0, 9, ticks + 1)[1:]  # mm
figure, (side, curve) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
for stitches in (0, 1, 3):
    sim, threads, gaps = pulled(stitches)
    name = "1 stitch" if stitches == 1 else f"{stitches} stitches"
    print(f"{name}: gap {gaps[-1]:.2f} mm")
    curve.plot(pulls, gaps, label=name)
    if stitches == 0:
        open_gap = gaps[-1]
places, triangles = 1e3 * sim.positions, sim.body.triangles
side.triplot(places[:, 0], places[:, 1], triangles[(places[triangles][:, :, 2] > 7).all(axis=1)], color="0.6", lw=0.5)
for thread in threads:
    way = 1e3 * thread.state.positions[[1, 4]]  # over the wound, between the tied passages
    side.plot(way[:, 0], way[:, 1], color="tab:blue", lw=2)
side.set(xlabel="x, mm", ylabel="y, mm", title="from above, pulled by 9 mm", aspect="equal")
curve.set(xlabel="pull, mm", ylabel="gap of the wound, mm")
curve.grid(alpha=0.3)
curve.legend()
figure.savefig(arguments.out, dpi=120)
assert gaps[-1] < 0.5 * open_gap, "the stitches did not hold"
