# SPDX-License-Identifier: MIT
"""A bean-shaped organ of 0.3 litres in a mesher's tetrahedra (Debian: gmsh, python3-numpy).

    python3 bean.py 600 2800        writes bean_600.vtu, bean_2800.vtu: about as many nodes

An ellipsoid, cut flat below, where it is held, and bent sideways: y += bend x^2, which leaves its volume alone. Gmsh
meshes the ellipsoid's surface; it is bent, and gmsh fills it. The mesh is stretched to the bean's volume, which facets
between points on its surface would fall short of.
"""
import base64
import os
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

AXES, BEND = np.array([0.07, 0.035, 0.03]), 4.0  # m, 1/m
CUT = 0.85  # of the lowest half axis
FLOOR = np.array([0, 0, -CUT * AXES[2]])
VOLUME = 4 / 3 * np.pi * AXES.prod() * (1 - (1 - CUT) ** 2 * (2 + CUT) / 4)


def bent(p):
    return p + np.outer(BEND * p[:, 0] ** 2, [0, 1, 0])


def straight(p):
    return p - np.outer(BEND * p[:, 0] ** 2, [0, 1, 0])


def read_msh(path):
    """Points, triangles and tetrahedra of an ASCII file of version 2.2."""
    lines = open(path, encoding="ascii").read().split("\n")
    start, first = lines.index("$Nodes") + 2, lines.index("$Elements") + 2
    nodes = [line.split() for line in lines[start:start + int(lines[start - 1])]]
    number = {node[0]: k for k, node in enumerate(nodes)}
    found = {"2": [], "4": []}
    for words in (line.split() for line in lines[first:first + int(lines[first - 1])]):
        if words[1] in found:
            found[words[1]].append([number[w] for w in words[3 + int(words[2]):]])
    return np.array([node[1:] for node in nodes], float), np.array(found["2"]), np.array(found["4"])


def gmsh(folder, text, dimension):
    with open(os.path.join(folder, "bean.geo"), "w", encoding="ascii") as file:
        file.write(text)
    subprocess.run(["gmsh", f"-{dimension}", "-format", "msh22", "-o", "out.msh", "bean.geo"], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    return read_msh(os.path.join(folder, "out.msh"))


def enclosed(p, triangles):
    a, b, c = (p[triangles[:, k]] for k in range(3))
    return abs(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def mesh(count, stretched, at_rim=1.0):
    """Points, surface triangles and tetrahedra; `count` points to 2 %. `at_rim`: edges there, in shares of the others."""
    size = (VOLUME / count) ** (1 / 3)
    for _ in range(10):
        found = mesh_of(size, stretched, at_rim)
        if abs(len(found[0]) / count - 1) < 0.02:
            break
        size *= (len(found[0]) / count) ** 0.4
    return found


def mesh_of(size, stretched, at_rim):
    to_rim = (f"Sqrt((z-({FLOOR[2]}))^2+({AXES[1]}*(Sqrt((x/{AXES[0]})^2+(y/{AXES[1]})^2)-{np.sqrt(1 - CUT**2)}))^2)")
    with tempfile.TemporaryDirectory() as folder:
        p, triangles, _ = gmsh(folder, f"""SetFactory("OpenCASCADE");
Sphere(1) = {{0, 0, 0, 1}}; Dilate {{{{0, 0, 0}}, {{{AXES[0]}, {AXES[1]}, {AXES[2]}}}}} {{ Volume{{1}}; }}
Box(2) = {{-1, -1, {FLOOR[2]}, 2, 2, 2}}; BooleanIntersection {{ Volume{{1}}; Delete; }} {{ Volume{{2}}; Delete; }}
Field[1] = MathEval; Field[1].F = "{size}*(1-{1 - at_rim}*Exp(-{to_rim}/0.01))"; Background Field = 1;
Mesh.CharacteristicLengthExtendFromBoundary = 0; Mesh.CharacteristicLengthFromPoints = 0;
""", 2)
        for _ in range(5 if stretched else 0):
            p = FLOOR + (p - FLOOR) * (VOLUME / enclosed(bent(p), triangles)) ** (1 / 3)
        p = bent(p)
        rows = [f"{k + 1} {x:.16g} {y:.16g} {z:.16g}" for k, (x, y, z) in enumerate(p)]
        cells = ["%d 2 2 1 1 %d %d %d" % (k + 1, *t) for k, t in enumerate(triangles + 1)]
        with open(os.path.join(folder, "surface.msh"), "w", encoding="ascii") as file:
            file.write("\n".join(["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(rows)), *rows,
                                  "$EndNodes", "$Elements", str(len(cells)), *cells, "$EndElements", ""]))
        # The surface's triangles stay as they are.
        return gmsh(folder, 'Merge "surface.msh"; Surface Loop(1) = {1}; Volume(1) = {1}; Mesh.SaveAll = 1;\n', 3)


def quadratic(count):
    """Points and 10-node tetrahedra, curved as the bean is; a quarter or so of the points are `count` corners."""
    points, triangles, cells = mesh(count, False, 0.25)
    volume = np.linalg.det(points[cells[:, 1:]] - points[cells[:, :1]])
    cells[volume < 0] = cells[volume < 0][:, [0, 2, 1, 3]]
    pairs = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
    edges, place = np.unique(np.sort(cells[:, pairs], axis=2).reshape(-1, 2), axis=0, return_inverse=True)
    middle = points[edges].mean(axis=1)
    on_floor = np.all(abs(points[triangles][:, :, 2] - FLOOR[2]) < 1e-9, axis=1)
    number = {tuple(e): k for k, e in enumerate(edges)}

    def sides(of):
        return {number[tuple(sorted((t[a], t[b])))] for t in of for a, b in ((0, 1), (1, 2), (2, 0))}
    curved, flat = sides(triangles[~on_floor]), sides(triangles[on_floor])
    for k in curved:
        q = straight(middle[k:k + 1])[0] / AXES
        if k in flat:  # on the rim
            q[:2] *= np.sqrt(1 - CUT**2) / np.linalg.norm(q[:2])
        else:
            q /= np.linalg.norm(q)
        middle[k] = bent((q * AXES)[None])[0]
    return np.vstack([points, middle]), np.hstack([cells, place.reshape(-1, 6) + len(points)])


def write_vtu(path, points, cells):
    def array(name, kind, values, parts=""):
        raw = np.ascontiguousarray(values).tobytes()
        packed = zlib.compress(raw, 9)
        head = struct.pack("<4I", 1, len(raw), 0, len(packed))
        text = base64.b64encode(head).decode() + base64.b64encode(packed).decode()
        return f'<DataArray type="{kind}" Name="{name}" format="binary"{parts}>{text}</DataArray>\n'
    with open(path, "w", encoding="ascii") as file:
        file.write('<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt32" '
                   'compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>'
                   f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}">\n<Points>'
                   + array("Points", "Float32", points.astype("<f4"), ' NumberOfComponents="3"') + "</Points>\n<Cells>"
                   + array("connectivity", "Int32", cells.astype("<i4"))
                   + array("offsets", "Int32", 4 * np.arange(1, len(cells) + 1, dtype="<i4"))
                   + array("types", "UInt8", np.full(len(cells), 10, "u1"))
                   + "</Cells></Piece></UnstructuredGrid></VTKFile>\n")


if __name__ == "__main__":
    for wanted in map(int, sys.argv[1:]):
        corners, _, tetrahedra = mesh(wanted, True)
        write_vtu(f"bean_{wanted}.vtu", corners, tetrahedra)
        print(f"bean_{wanted}.vtu: {len(corners)} nodes, {len(tetrahedra)} tetrahedra")
