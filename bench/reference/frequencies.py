# SPDX-License-Identifier: MIT
"""Natural frequencies of the clamped beam of truth.csv by converged finite elements: 20-node bricks, full integration,
consistent mass, four meshes.

    python3 frequencies.py [cells across ...]        (Debian: python3-scipy)

Beam 0.2 x 0.05 x 0.05 m, its side x = 0 clamped, E = 10 kPa, nu = 0.3, density 1000 kg/m^3. Prints the first bending
frequency (a pair), the first of torsion and the second of bending (a pair), Hz; the frequency of the first stretching
is the last one.
"""
import argparse
import itertools

import numpy as np

SIZE, YOUNG, POISSON, DENSITY = (0.2, 0.05, 0.05), 1e4, 0.3, 1000.0
BRICK = np.array([p for p in itertools.product((-1, 0, 1), repeat=3) if sum(c == 0 for c in p) <= 1], float)


def shapes(at):
    """Serendipity functions of the 20 nodes, and their gradients, at a place of the reference cube."""
    def value(place):
        f = 1 + BRICK * place
        corner = np.prod(f, axis=1) * ((BRICK * place).sum(axis=1) - 2) / 8
        edge = np.prod(np.where(BRICK == 0, 1 - place**2, f), axis=1) / 4
        return np.where((BRICK == 0).any(axis=1), edge, corner)
    step = 1e-5  # the functions are quadratic along each axis: central differences are exact up to rounding
    gradient = [(value(at + step * e) - value(at - step * e)) / (2 * step) for e in np.eye(3)]
    return value(at), np.array(gradient).T


def element(sides):
    """Stiffness and mass of a box-shaped brick, [60 x 60]."""
    lame = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    shear = YOUNG / (2 * (1 + POISSON))
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    stiffness, mass = np.zeros((60, 60)), np.zeros((60, 60))
    points, weights = np.polynomial.legendre.leggauss(3)
    for at in itertools.product(range(3), repeat=3):
        n, g = shapes(points[list(at)])
        g = g * 2 / sides
        weight = np.prod(weights[list(at)]) * np.prod(sides) / 8
        strain = np.zeros((6, 60))
        for row, (a, b) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]):
            strain[row, a::3] += g[:, b]
            if a != b:
                strain[row, b::3] += g[:, a]
        stiffness += weight * strain.T @ law @ strain
        mass += weight * DENSITY * np.kron(np.outer(n, n), np.eye(3))
    return stiffness, mass


def frequencies(across):
    """Hz, of the modes below the first stretching and that one, in order."""
    import scipy.sparse as sparse
    import scipy.sparse.linalg as solvers
    cells = np.array([4 * across, across, across])
    sides = np.array(SIZE) / cells
    stiffness, mass = element(sides)
    numbers, nodes = {}, []
    for cell in itertools.product(*map(range, cells)):
        places = np.rint(2 * np.array(cell) + 1 + BRICK).astype(int)
        nodes.append([numbers.setdefault(tuple(p), len(numbers)) for p in places])
    degrees = (3 * np.array(nodes)[:, :, None] + np.arange(3)).reshape(len(nodes), 60)
    rows, columns = np.repeat(degrees, 60, axis=1).ravel(), np.tile(degrees, 60).ravel()
    free = np.repeat(np.array([p[0] > 0 for p in numbers]), 3)
    def matrix(m):
        whole = sparse.csc_matrix((np.tile(m.ravel(), len(nodes)), (rows, columns)))
        return whole[free][:, free]
    found = solvers.eigsh(matrix(stiffness), 6, matrix(mass), sigma=0, return_eigenvectors=False)
    return np.sort(np.sqrt(found)) / (2 * np.pi)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("across", type=int, nargs="*", help="cells across, coarse to fine (default 2 4 6 8)")
    for n in parser.parse_args().across or (2, 4, 6, 8):
        print(f"frequencies.py {n} across:", " ".join(f"{f:.5f}" for f in frequencies(n)))
