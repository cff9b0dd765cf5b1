# SPDX-License-Identifier: MIT
"""Solves a deck with CalculiX and compares it with the samples kept here: where the reference numbers come from.

    python3 calculix.py                                          the bar, nu 0.30 (Debian: calculix-ccx, python3-numpy)
    python3 calculix.py DECK SAMPLES LEVEL...                    another: one level for each step of the deck

The decks are of the coarsest of three meshes; the samples of the finest. The difference is the coarse mesh's error.
Returns failure where it is above --bound (default 0.01).
"""
import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

here = os.path.dirname(os.path.abspath(__file__))
CORNERS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
MIDDLES = np.array([(CORNERS[a] + CORNERS[b]) / 2 for a, b in EDGES])


def shape_functions(p):
    """Of the 20-node brick at local coordinates."""
    corner = [np.prod(1 + c * p) * (c @ p - 2) / 8 for c in CORNERS]
    middle = [np.prod(np.where(m == 0, 1 - p**2, 1 + m * p)) / 4 for m in MIDDLES]
    return np.array(corner + middle)


def read_deck(path):
    nodes, elements, block, pending = {}, [], "", []
    with open(path, encoding="ascii") as file:
        for line in file:
            if line.startswith("*"):
                block = line.strip().upper()
                continue
            numbers = [f for f in line.strip().split(",") if f.strip()]
            if block.startswith("*NODE,"):
                nodes[int(numbers[0])] = np.array([float(f) for f in numbers[1:4]])
            elif block.startswith("*ELEMENT"):
                pending += [int(f) for f in numbers]
                if len(pending) == 21:
                    elements.append(pending[1:])
                    pending = []
    return nodes, elements


def read_results(path):
    """Displacements by node, one dictionary for each step."""
    steps = []
    with open(path, encoding="ascii") as file:
        for line in file:
            fields = line.split()
            if "displacements" in line:
                steps.append({})
            elif "total force" in line:
                pass
            elif len(fields) == 4 and fields[0].isdigit() and steps:
                steps[-1][int(fields[0])] = np.array([float(f) for f in fields[1:]])
    return steps


def place(point, nodes, elements):
    """Element and shape functions at a point of the rest shape, by Newton's method."""
    best = (np.inf, None, None)
    for element in elements:
        x = np.array([nodes[i] for i in element])
        low, high = x.min(axis=0), x.max(axis=0)
        if np.any(point < low - 1e-3 * (high - low)) or np.any(point > high + 1e-3 * (high - low)):
            continue
        p = np.zeros(3)
        for _ in range(20):
            slope = np.array([(shape_functions(p + d) - shape_functions(p - d)) @ x / 2e-6 for d in 1e-6 * np.eye(3)]).T
            move = np.linalg.solve(slope, point - shape_functions(p) @ x)
            p += move
            if np.abs(move).max() < 1e-12:
                break
        outside = np.abs(p).max()
        if outside < best[0]:
            best = (outside, element, shape_functions(p))
    if best[1] is None:
        sys.exit(f"sample point {point} is outside the mesh")
    return best[1], best[2]


def main():
    parser = argparse.ArgumentParser(description="Solves a deck with CalculiX and compares it with the samples.")
    parser.add_argument("deck", nargs="?", default=os.path.join(here, "decks", "bar_stretched_nu0.30.inp"))
    parser.add_argument("samples", nargs="?", default=os.path.join(here, "samples", "bar_stretched.csv"))
    parser.add_argument("levels", nargs="*", default=["nu0.30_s0.05", "nu0.30_s0.10", "nu0.30_s0.20"])
    parser.add_argument("--bound", type=float, default=0.01)
    given = parser.parse_args()
    if shutil.which("ccx") is None:
        sys.exit("calculix.py: expected the program ccx; on Debian: apt-get install calculix-ccx")
    nodes, elements = read_deck(given.deck)
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(given.deck, os.path.join(folder, "deck.inp"))
        subprocess.run(["ccx", "-i", "deck"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        steps = read_results(os.path.join(folder, "deck.dat"))
    if len(steps) != len(given.levels):
        sys.exit(f"calculix.py: the deck has {len(steps)} steps, {len(given.levels)} levels were named")
    with open(given.samples, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    worst = 0.0
    for level, result in zip(given.levels, steps):
        off = size = 0.0
        for row in (r for r in rows if r["level"] == level):
            element, weights = place(np.array([float(row[k]) for k in "xyz"]), nodes, elements)
            found = weights @ np.array([result[i] for i in element])
            kept = np.array([float(row[k]) for k in ("ux", "uy", "uz")])
            off += np.sum((found - kept) ** 2)
            size += np.sum(kept**2)
        difference = np.sqrt(off / size)
        worst = max(worst, difference)
        print(f"{level}: |u - u_kept| / |u_kept| = {difference:.2e}")
    if not worst <= given.bound:
        sys.exit(f"calculix.py: above {given.bound}")


if __name__ == "__main__":
    main()
