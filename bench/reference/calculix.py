# SPDX-License-Identifier: MIT
"""Solves a reference case with CalculiX, and compares with the samples kept here: where the reference numbers come from.

    python3 calculix.py                              the bar, nu 0.30 (Debian: calculix-ccx, python3-numpy; bean: gmsh)
    python3 calculix.py cantilever 0.49 --write      the finest mesh's rows go into samples/
    python3 calculix.py cube_bonded 0.49 --n 8 12 --element C3D20

Decks are made from the case file: its body in 20-node bricks (files: 10-node tetrahedra), a step for each level of that
Poisson's ratio, the half or quarter of what is symmetric. Every level prints the forces, how far each mesh is from the
finest, and how far that is from the samples kept. Returns failure where this is above --bound.
"""
import argparse
import cmath
import csv
import math
import os
import subprocess
import sys
import tempfile

import numpy as np

here = os.path.dirname(os.path.abspath(__file__))
CORNERS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
BRICK = np.vstack([CORNERS, [(CORNERS[a] + CORNERS[b]) / 2 for a, b in EDGES]])
TETRA_EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]

# Resolutions n of the case file's cells, and the axes that the planes of symmetry are across.
MESHES = {
    "cantilever": ((4, 6, 8), "y"), "bar_stretched": ((4, 6, 8), "yz"), "cube_bonded": ((8, 12, 16), "xy"),
    "cube_slip": ((2, 4), "xy"), "block_indented": ((3, 4, 5), "xy"), "cylinder_sheared": ((2, 4, 6), "y"),
    "cylinder_compressed": ((2, 4, 6), "xy"), "bean": ((600, 1500), "")}


def evaluate(text, names):
    for ours, python in (("^", "**"), ("&&", " and "), ("||", " or "), ("if(", "choose(")):
        text = text.replace(ours, python)
    known = {k: getattr(math, k) for k in "sin cos tan asin acos atan2 sqrt exp log pi".split()}
    known.update(abs=abs, min=min, max=max, choose=lambda c, a, b: a if c else b)
    return eval(text, {"__builtins__": {}}, {**known, **names})


class Case:
    def __init__(self, name):
        self.lines = [line.split("#")[0].split() for line in open(os.path.join(here, name + ".case"), encoding="utf-8")]
        self.lines = [words for words in self.lines if words]

    def all(self, key):
        return [words[1:] for words in self.lines if words[0] == key]

    def one(self, key):
        return (self.all(key) or [None])[0]

    def names(self, level, n):
        names = {"n": n}
        for key, value in [v.split("=") for v in level[1:]] + self.all("let"):
            names[key] = evaluate(value, names)
        return names


def at(names, point):
    return {**names, "x": point[0], "y": point[1], "z": point[2]}


class Mesh:
    """Points, elements and groups; what is symmetric is cut away, the plane's points are in groups '-x', '-y', '-z'."""

    def __init__(self, case, names, axes):
        body, *args = case.one("body")
        if body == "file":
            import bean
            self.points, self.elements = bean.quadratic(int(names["n"]))
            ends = {}
        else:
            args = [evaluate(a, names) for a in args]
            cells = [int(evaluate(c, names)) for c in case.one("cells")]
            length = args[-1] if body == "cylinder" else args[2]
            patches = [(cells, lambda s: s * args)] if body == "block" else disc(args[0], args[1], cells)
            self.weld(patches)
            self.middle = np.array(args) / 2 if body == "block" else np.zeros(3)
            ends = {"x0": (0, 0.0), "x1": (0, args[0]), "y0": (1, 0.0), "y1": (1, args[1]), "z0": (2, 0.0),
                    "z1": (2, length)} if body == "block" else {"bottom": (2, 0.0), "top": (2, length)}
            self.fold(axes)
        self.groups = {name: np.flatnonzero(abs(self.points[:, a] - v) < 1e-9) for name, (a, v) in ends.items()}
        for axis in axes:
            on_plane = abs(self.points[:, "xyz".index(axis)] - self.middle["xyz".index(axis)]) < 1e-9
            self.groups["-" + axis] = np.flatnonzero(on_plane)
        if case.one("map") and body == "block":
            self.points = np.array([[evaluate(m, at(names, p)) for m in case.one("map")] for p in self.points])
        for name, *condition in case.all("group"):
            meets = [evaluate(" ".join(condition), at(names, p)) for p in self.points]
            self.groups[name] = np.flatnonzero(meets)

    def weld(self, patches):
        number, self.elements = {}, []
        for cells, place in patches:
            for low in np.ndindex(*cells):
                points = [place((np.array(low) + (1 + b) / 2) / cells) for b in BRICK]
                self.elements.append([number.setdefault(tuple(np.round(p, 9) + 0.0), len(number)) for p in points])
        self.points, self.elements = np.array(list(number)), np.array(self.elements)

    def fold(self, axes):
        for axis in ("xyz".index(a) for a in axes):
            centres = self.points[self.elements].mean(axis=1)[:, axis]
            self.elements = self.elements[centres > self.middle[axis]]
        used, renumbered = np.unique(self.elements, return_inverse=True)
        self.points, self.elements = self.points[used], renumbered.reshape(self.elements.shape)


def disc(radius, length, cells):
    """A square of half the radius inside four patches that end on the circle: `cells` is rings, sectors, layers."""
    def patch(turn):
        def place(s):
            t = 2 * s[1] - 1
            xy = (1 - s[0]) * (0.5 + 0.5j * t) + s[0] * cmath.exp(0.25j * math.pi * t)
            xy = radius * (xy * turn if turn else complex(s[0] - 0.5, s[1] - 0.5))
            return np.array([xy.real, xy.imag, length * s[2]])
        return (cells[0], cells[0], cells[2]), place
    return [patch(turn) for turn in (0, 1, 1j, -1, -1j)]


def shape_functions(p, count):
    if count == 10:
        l = np.array([1 - p.sum(), *p])
        return np.array([*(l * (2 * l - 1)), *(4 * l[a] * l[b] for a, b in TETRA_EDGES)])
    corner = [np.prod(1 + c * p) * (c @ p - 2) / 8 for c in CORNERS]
    middle = [np.prod(np.where(m == 0, 1 - p**2, 1 + m * p)) / 4 for m in BRICK[8:]]
    return np.array(corner + middle)


def find(mesh, point):
    """Element and shape functions at a point of the rest shape, by Newton's method."""
    x = mesh.points[mesh.elements]
    low, high = x.min(axis=1), x.max(axis=1)
    slack = 0.02 * (high - low)
    best = (np.inf, None, None)
    for e in np.flatnonzero(np.all((point > low - slack) & (point < high + slack), axis=1)):
        count = mesh.elements.shape[1]
        p = np.full(3, 0.25 if count == 10 else 0.0)
        for _ in range(20):
            slope = np.array([shape_functions(p + d, count) - shape_functions(p - d, count) for d in 1e-6 * np.eye(3)])
            move = np.linalg.solve((slope @ x[e] / 2e-6).T, point - shape_functions(p, count) @ x[e])
            p = p + move
            if np.abs(move).max() < 1e-12:
                break
        outside = max(-p.min(), p.sum() - 1) if count == 10 else np.abs(p).max() - 1
        if outside < best[0]:
            best = (outside, mesh.elements[e], shape_functions(p, count))
    if best[0] > 0.1:
        sys.exit(f"calculix.py: the point {point} is outside the mesh")
    return best[1], best[2]


def deck(case, mesh, levels, n, element):
    young, poisson, density = (evaluate(v, case.names(levels[0], n)) for v in case.one("material"))
    mu, bulk = young / 2 / (1 + poisson), young / 3 / (1 - 2 * poisson)
    text = ["*NODE,NSET=NALL"] + ["%d,%.12g,%.12g,%.12g" % (i + 1, *p) for i, p in enumerate(mesh.points)]
    text.append(f"*ELEMENT,TYPE={element},ELSET=EALL")
    for e, nodes in enumerate(mesh.elements + 1):
        row = [str(e + 1), *map(str, nodes)]
        text += [",".join(row[:11]) + ","[:len(row) > 11]] + [",".join(row[11:])] * (len(row) > 11)
    reactions = [r[0] for r in case.all("reaction")]
    for group in reactions:
        text += [f"*NSET,NSET={group}", *(f"{i + 1}," for i in mesh.groups[group])]
    # Residuals of a thousandth of the forces: five times as exact as the default.
    text += ["*MATERIAL,NAME=M", "*HYPERELASTIC,NEO HOOKE", f"{mu / 2:.12g},{2 / bulk:.12g}", "*DENSITY", f"{density}",
             "*SOLID SECTION,ELSET=EALL,MATERIAL=M", "*CONTROLS,PARAMETERS=FIELD", "1e-3,1e-2"]
    for level in levels:
        names = case.names(level, n)
        imposed = {(i, "xyz".index(g[1])): 0.0 for g in mesh.groups if g[0] == "-" for i in mesh.groups[g]}
        for words in case.lines:
            if words[0] in ("fix", "move"):
                for i in mesh.groups[words[1]]:
                    for axis, value in enumerate(words[2:] or ["0"] * 3):
                        if value != "-":
                            imposed[i, axis] = evaluate(value, at(names, mesh.points[i]))
        text += ["*STEP,NLGEOM,INC=1000", "*STATIC", "0.2,1.,1e-6,1.", "*BOUNDARY"]
        text += ["%d,%d,%d,%.12g" % (i + 1, axis + 1, axis + 1, v) for (i, axis), v in sorted(imposed.items())]
        gravity = np.array([evaluate(g, names) for g in case.one("gravity") or "000"])
        if gravity.any():
            size = np.linalg.norm(gravity)
            text += ["*DLOAD", "EALL,GRAV,%.12g,%.12g,%.12g,%.12g" % (size, *(gravity / size))]
        text += ["*NODE PRINT,NSET=NALL,FREQUENCY=1000", "U"]
        for group in reactions:
            text += [f"*NODE PRINT,NSET={group},TOTALS=ONLY,FREQUENCY=1000", "RF"]
        text.append("*END STEP")
    return "\n".join(text) + "\n"


def solve(text, count):
    """Displacements [nodes] and total force for each step."""
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "deck.inp"), "w", encoding="ascii") as file:
            file.write(text)
        run = subprocess.run(["ccx", "-i", "deck"], cwd=folder, stdout=subprocess.PIPE, text=True, check=False)
        if run.returncode != 0 or "*ERROR" in run.stdout:
            sys.exit("calculix.py: ccx failed:\n" + run.stdout[-2000:])
        steps, forces, totals = [], [], False
        with open(os.path.join(folder, "deck.dat"), encoding="ascii") as file:
            for line in file:
                fields = line.split()
                if "displacements" in line:
                    steps.append(np.zeros((count, 3)))
                elif "total force" in line:
                    totals = True
                elif totals and len(fields) == 3:
                    forces.append(np.array(fields, float))
                    totals = False
                elif len(fields) == 4 and fields[0].isdigit():
                    steps[-1][int(fields[0]) - 1] = [float(f) for f in fields[1:]]
    return steps, forces or [np.zeros(3)] * len(steps)


def solve_case(case, levels, n, axes, points, element):
    """Displacements at the points, and total force, of each level."""
    mesh = Mesh(case, case.names(levels[0], n), axes)
    element = element if mesh.elements.shape[1] == 20 else "C3D10"
    steps, forces = solve(deck(case, mesh, levels, n, element), len(mesh.points))
    signs, folded = np.ones_like(points), points.copy()
    for axis in ("xyz".index(a) for a in axes):
        below = points[:, axis] < mesh.middle[axis]
        signs[below, axis] = -1
        folded[below, axis] = 2 * mesh.middle[axis] - points[below, axis]
    places = [find(mesh, p) for p in folded]
    u = [signs * [weights @ step[nodes] for nodes, weights in places] for step in steps]
    whole = np.array([0.0 if a in axes else 2.0 ** len(axes) for a in "xyz"])
    print(f"n {n}: {len(mesh.points)} nodes, {len(mesh.elements)} {element}", flush=True)
    return u, [f * whole for f in forces]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", choices=MESHES, nargs="?", default="bar_stretched")
    parser.add_argument("poisson", type=float, nargs="?", default=0.3)
    parser.add_argument("--n", type=int, nargs="+", help="resolutions, from coarse to fine")
    parser.add_argument("--element", default="C3D20R", help="bricks: C3D20R (reduced integration) or C3D20")
    parser.add_argument("--bound", type=float, default=0.01, help="of the difference from the samples kept")
    parser.add_argument("--write", action="store_true", help="the finest mesh's displacements become the samples")
    given = parser.parse_args()
    case = Case(given.case)
    levels = [level for level in case.all("level") if f"nu={given.poisson:.2f}" in level]
    path = os.path.join(here, case.one("samples")[0])
    with open(path, encoding="utf-8") as file:
        rows = list(csv.reader(file))
    points = np.array([r[1:4] for r in rows[1:] if r[0] == rows[1][0]], float)  # the same for all levels
    meshes, axes = MESHES[given.case]
    found = [solve_case(case, levels, n, axes, points, given.element) for n in given.n or meshes]
    (finest, forces), worst = found[-1], 0.0
    for k, level in enumerate(levels):
        def off(u):
            return "%.1e" % (np.linalg.norm(u - finest[k]) / np.linalg.norm(finest[k]))
        kept = np.array([r[4:] for r in rows if r[0] == level[0]], float)
        worst = max(worst, float(off(kept)) if len(kept) else 0.0)
        size = np.linalg.norm(forces[k]) or 1.0
        print(level[0], "force", " ".join("%.6g" % f for f in forces[k]), "| off the finest mesh:",
              *("%s (force %.1e)" % (off(u[k]), np.linalg.norm(f[k] - forces[k]) / size) for u, f in found[:-1]),
              "| the samples kept:", off(kept) if len(kept) else "none")
    if given.write:
        named = [level[0] for level in levels]
        rows = [r for r in rows if r[0] not in named]
        rows += [[level] + ["%.7g" % v for v in (*p, *u)] for level, us in zip(named, finest) for p, u in zip(points, us)]
        with open(path, "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)
    elif worst > given.bound:
        sys.exit(f"calculix.py: the samples kept are {worst} off; expected at most {given.bound}")


if __name__ == "__main__":
    main()
