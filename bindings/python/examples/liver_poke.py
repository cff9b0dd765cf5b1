# SPDX-License-Identifier: MIT
"""A soft organ, held from below, is poked by a ball; draws the force on the ball over its depth."""

import argparse
import pathlib

import matplotlib
import numpy as np

import phymul

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

sample = pathlib.Path(__file__).resolve().parents[3] / "examples/data/bean.stl"
parser = argparse.ArgumentParser(prog="liver_poke.py", description=__doc__)
parser.add_argument("--surface", default=sample, help="closed surface in millimetres (STL, OBJ, PLY)")
parser.add_argument("--out", default="liver_poke.png", help="the picture")
parser.add_argument("--quick", action="store_true", help="a coarser body, fewer ticks")
arguments = parser.parse_args()

vertices, triangles = phymul.read_surface(arguments.surface, 1e-3)
organ = phymul.make_body(vertices, triangles, 0.012 if arguments.quick else 0.006)
low, high = organ.rest.min(axis=0), organ.rest.max(axis=0)
organ.add_group("held", organ.rest[:, 2] < low[2] + 0.2 * (high[2] - low[2]))

sim = phymul.Simulation(organ, young=5e3, poisson=0.45, density=1050, damping=20)
sim.fix("held")
skin = sim.bind(vertices, triangles)
radius, depth, ticks = 0.01, 0.012, 100 if arguments.quick else 1000
x, y = organ.rest[np.argmax(organ.rest[:, 2]), :2]  # above the highest particle
start = high[2] + radius
ball = sim.add_tool(phymul.Sphere(radius), phymul.Pose((x, y, start)), contact="surface")

depths, forces = [], []
for tick in range(2 * ticks):
    at = depth * (1 - abs(tick + 1 - ticks) / ticks)  # down and up again
    ball.move_to(phymul.Pose((x, y, start - at)))
    sim.advance(1.0 / ticks)
    depths.append(at)
    forces.append(ball.force.mean_force[2])
    if tick + 1 == ticks:
        pressed = skin.deform()[0].copy()
print(f"{organ.particles} particles, at most {max(forces):.2f} N")

figure = plt.figure(figsize=(11, 4.5), layout="constrained")
moved = 1e3 * np.linalg.norm(pressed - vertices, axis=1)
axes = figure.add_subplot(121, projection="3d")
surface = axes.plot_trisurf(*(1e3 * pressed.T), triangles=triangles, cmap="viridis", linewidth=0)
surface.set_array(moved[triangles].mean(axis=1))
surface.autoscale()
axes.set_box_aspect(np.ptp(pressed, axis=0))
axes.set(xlabel="x, mm", ylabel="y, mm", zlabel="z, mm")
figure.colorbar(surface, ax=axes, label="moved by, mm", shrink=0.6, pad=0.15)
right = figure.add_subplot(122)
right.plot(1e3 * np.array(depths[:ticks]), forces[:ticks], label="down")
right.plot(1e3 * np.array(depths[ticks:]), forces[ticks:], label="up")
right.set(xlabel="depth, mm", ylabel="force on the ball, N")
right.grid(alpha=0.3)
right.legend()
figure.savefig(arguments.out, dpi=120)
assert max(forces) > 0.1, "the ball felt nothing"
