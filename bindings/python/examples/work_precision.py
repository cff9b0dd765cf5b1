# SPDX-License-Identifier: MIT
"""Error of a cantilever's rest shape over its spacing and over the time to find it, against a finer body."""

import argparse
import time

import matplotlib
import numpy as np

import phymul

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

parser = argparse.ArgumentParser(prog="work_precision.py", description=__doc__)
parser.add_argument("--out", default="work_precision.png", help="the picture")
parser.add_argument("--quick", action="store_true", help="coarser bodies")
arguments = parser.parse_args()

size = np.array((0.2, 0.05, 0.05))  # m
grid = (np.stack(np.meshgrid(*[np.linspace(0.1, 0.9, 5)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)) * size


def rest_shape(across):
    """Displacements of the same places in a body of `across` cells across, and s for the solve alone."""
    body = phymul.make_block(size, 4 * across, across, across)
    sim = phymul.Simulation(body, young=10e3, poisson=0.45, density=1000, backend="reference")
    sim.fix("x0").gravity((0, 0, -0.5))
    skin = sim.bind(grid)
    sim.stable_step  # makes the solver, which is not to be timed
    begin = time.perf_counter()
    report = sim.solve_static()
    seconds = time.perf_counter() - begin
    assert report.converged, report.message
    return skin.deform()[0] - grid, seconds


levels = (2, 3, 4) if arguments.quick else (2, 3, 4, 6, 8, 12)
finest = 6 if arguments.quick else 20
reference, _ = rest_shape(finest)
spacings, errors, times = [], [], []
for across in levels:
    found, seconds = rest_shape(across)
    spacings.append(1e3 * size[1] / across)
    errors.append(100 * np.sqrt(((found - reference)**2).sum() / (reference**2).sum()))
    times.append(seconds)
    print(f"{across:2} cells across: {errors[-1]:6.2f} % in {times[-1]:.3f} s")

figure, panels = plt.subplots(1, 2, figsize=(9, 4), layout="constrained", sharey=True)
for panel, values, label in zip(panels, (spacings, times), ("edge of a lattice cell, mm", "time of solve_static, s")):
    panel.loglog(values, errors, "o-")
    panel.set(xlabel=label)
    panel.grid(which="both", alpha=0.3)
panels[0].set(ylabel=f"error against {finest} cells across, %")
figure.savefig(arguments.out, dpi=120)
assert errors == sorted(errors, reverse=True), "a finer body has a larger error"
