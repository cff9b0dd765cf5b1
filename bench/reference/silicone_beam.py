# SPDX-License-Identifier: MIT
"""Reads the six recordings of the silicone beam: where the figures of measured.csv that begin with "beam" come from.

    python3 silicone_beam.py FOLDER        (Debian: python3-numpy; git)
    python3 silicone_beam.py FOLDER --points ../../examples/studies/silicone_points.csv

FOLDER: a clone of https://github.com/srl-ethz/diffPD_sim2real. For each recording prints how far the three marks on
the free end have come down, mm, along the vertical of the recording and, in brackets, along that of the beam, whose
frame is fitted to the six markers in the first frames; the largest distance of a marker from its nominal place after
that fit, mm; how far the markers beside the clamp move, mm; and without a load the mean period of eight swings, s.
--points writes what examples/studies/silicone_beam.study reads: places and displacements of the three marks under the
heaviest load, m, means of the two recordings, along the beam, across it and up. The top mark is brought from its
marker, 6 mm above, to the surface, by the angle that the other marks have turned.
"""
import argparse
import struct
import subprocess

import numpy as np

PATH = "python/realbeam_experiments/Measurement_data/beam_"
NAMES = ("gravity_V2_a", "gravity_V2_b", "load52_V2_a", "load52_V2_b", "load101_V2_a", "load101_V2_b")
# Nominal places of the markers in the frame of the beam, m: three on the free end, three beside the clamp.
NOMINAL = np.array([[0, 0.015, 0.036], [0, -0.006, 0.024], [0, 0.036, 0.006],
                    [-0.094, -0.01, -0.001], [-0.094, 0.04, 0.0275], [-0.094, 0.04, 0]])
RATE = 100.0  # Hz


def read(data):
    """[frames, markers, 3] m, of a C3D file of single precision without analogue channels."""
    markers, _, first, last = struct.unpack("<4H", data[2:10])
    block, = struct.unpack("<H", data[16:18])
    rows = np.frombuffer(data, "<f4", (last - first + 1) * markers * 4, (block - 1) * 512)
    return rows.reshape(-1, markers, 4)[:, :, :3].astype(float)


def fitted(places):
    """Rotation and shift that bring places next to the nominal ones (Kabsch)."""
    centre, wanted = places.mean(0), NOMINAL.mean(0)
    u, _, v = np.linalg.svd((places - centre).T @ (NOMINAL - wanted))
    turn = v.T @ np.diag([1, 1, np.linalg.det(v.T @ u.T)]) @ u.T
    return turn, wanted - turn @ centre


parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder")
parser.add_argument("--points", help="file to write")
given = parser.parse_args()
folder, heaviest = given.folder, []
for name in NAMES:
    at = read(subprocess.run(["git", "-C", folder, "show", f"HEAD:{PATH}{name}.c3d"], check=True,
                             capture_output=True).stdout)
    first, last = at[:5].mean(0), at[-60:].mean(0)
    turn, shift = fitted(first)
    moved = 1e3 * (last - first)
    turned = moved @ turn.T
    height = at[:, 0, 0] - last[0, 0]
    down = [k - 1 + height[k - 1] / (height[k - 1] - height[k])
            for k in range(1, len(height)) if height[k - 1] > 0 >= height[k]]
    swings = min(8, len(down) - 1)
    print(f"silicone_beam.py {name}:", " ".join(f"{a:.2f} ({b:.2f})" for a, b in zip(moved[:3, 0], turned[:3, 2])),
          f"off {1e3 * np.linalg.norm(first @ turn.T + shift - NOMINAL, axis=1).max():.1f},",
          f"clamp {np.linalg.norm(moved[3:], axis=1).max():.2f}" +
          (f", period {(down[swings] - down[0]) / RATE / swings:.4f}" if "gravity" in name else ""))
    if "101" in name:
        heaviest.append((last - first)[:3, ::-1] * (1, -1, 1))
if given.points:
    moved = np.mean(heaviest, axis=0)
    angle = np.arcsin((moved[0, 0] - moved[2, 0]) / 0.030)
    moved[0] -= 0.006 * np.array([np.sin(angle), 0, np.cos(angle) - 1])
    with open(given.points, "w", encoding="utf-8") as file:
        file.write("x,y,z,ux,uy,uz\n")
        for place, u in zip(("0.1,0.015,0.03", "0.1,0,0.024", "0.1,0.03,0.006"), moved):
            file.write(place + "".join(f",{c:.6f}" for c in u) + "\n")
