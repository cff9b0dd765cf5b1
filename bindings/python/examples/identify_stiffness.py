# SPDX-License-Identifier: MIT
"""Young's modulus of a sample from measured displacements: least squares (Gauss-Newton, slope by secant)."""

import argparse

import matplotlib
import numpy as np

import phymul

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

parser = argparse.ArgumentParser(prog="identify_stiffness.py", description=__doc__)
parser.add_argument("--out", default="identify_stiffness.png", help="the picture")
parser.add_argument("--quick", action="store_true", help="coarser bodies")
arguments = parser.parse_args()

size = np.array((0.1, 0.03, 0.03))  # m
markers = np.array([(x, 0.015, 0.03) for x in np.linspace(0.01, 0.095, 12)])  # on the upper side


def sagged(young, across):
    """Displacements of the markers, m, of a sample that is held at one end and sags under its weight."""
    body = phymul.make_tetrahedral_block(size, 3 * across, across, across)
    sim = phymul.Simulation(body, young=young, poisson=0.45, density=1000, backend="reference")
    sim.fix("x0").gravity((0, 0, -9.81))
    report = sim.solve_static()
    assert report.converged, report.message
    return sim.bind(markers).deform()[0] - markers


# The measurement: of a finer body, whose modulus is to be found, with noise of 0.1 mm.
true_young, noise, across = 30e3, 1e-4, 3 if arguments.quick else 5
random = np.random.default_rng(1)
measured = sagged(true_young, 4 if arguments.quick else 8) + noise * random.standard_normal(markers.shape)

# Unknown: s = ln E, so that E stays positive. The residual is r(s); each step minimises |r + (dr/ds) ds|.
s = [np.log(10e3), np.log(12e3)]
r = [(sagged(np.exp(each), across) - measured).ravel() for each in s]
while abs(s[-1] - s[-2]) > 1e-4 and len(s) < 20:
    slope = (r[-1] - r[-2]) / (s[-1] - s[-2])
    s.append(s[-1] + np.clip(-slope @ r[-1] / (slope @ slope), -1.0, 1.0))
    r.append((sagged(np.exp(s[-1]), across) - measured).ravel())
    print(f"E = {np.exp(s[-1]):8.0f} Pa, rms distance {1e3 * np.sqrt((r[-1]**2).mean()):.3f} mm")
found = np.exp(s[-1])
print(f"found {found / 1e3:.2f} kPa, true {true_young / 1e3:.2f} kPa")

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
left.plot(1e3 * markers[:, 0], 1e3 * measured[:, 2], "k.", label="measured")
for which, style in ((0, "--"), (-1, "-")):
    shape = r[which].reshape(-1, 3) + measured
    left.plot(1e3 * markers[:, 0], 1e3 * shape[:, 2], style, label=f"E = {np.exp(s[which]) / 1e3:.1f} kPa")
left.set(xlabel="x, mm", ylabel="marker moved in z by, mm")
left.legend()
right.semilogy([np.sqrt((each**2).mean()) * 1e3 for each in r], "o-")
right.axhline(1e3 * noise, color="grey", linestyle=":", label="noise")
right.set(xlabel="try", ylabel="rms distance, mm")
right.legend()
figure.savefig(arguments.out, dpi=120)
assert abs(found / true_young - 1) < 0.1, "not the modulus that was put in"
