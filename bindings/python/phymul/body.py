# SPDX-License-Identifier: MIT
"""Bodies and surfaces."""

from __future__ import annotations

import ctypes
import os
from dataclasses import asdict, dataclass
from typing import Any, Optional, Sequence, Union

import numpy as np

from ._library import (Error, Handle, Owner, constants, cut_along, floats, integers, library, lines_of, make,
                       other_than_zero, path_of, rows_of, sized, structs, view, view_of)

Path = Union[str, "os.PathLike[str]"]
Vector = Union[Sequence[float], np.ndarray]

_sizes = {"tetrahedron": 4, "wedge": 6, "pyramid": 5, "hexahedron": 8}


_stiffening = ("exponential", "exponent", "second", "second_fades")


@dataclass(frozen=True)
class Material:
    young: float  # Pa
    poisson: float
    density: float  # kg/m^3
    retardation_time: float = 0.0  # s; this and the next two are its dissipation, 0: none
    relaxation_strength: float = 0.0
    relaxation_time: float = 0.0  # s
    exponential: float = 0.0  # this and the next three are its stiffening beyond small strains, 0: none
    exponent: float = 0.0
    second: float = 0.0
    second_fades: float = 0.0
    thickness: float = 0.0  # m, of walls of triangles; 0: not a wall

    @property
    def _struct(self) -> Any:
        fields = asdict(self)
        return sized("phymul_material", stiffening=tuple(fields.pop(name) for name in _stiffening), **fields)


@dataclass(frozen=True)
class MaterialFit:
    material: Material
    stress: np.ndarray  # Pa, of the material at the points of uniaxial, then of shear
    largest_error: float  # relative


def fit_material(uniaxial: Any = (), shear: Any = (), *, poisson: float, density: float, goal: str = "least_squares",
                 terms: Sequence[str] = ("exponential", "second", "second_fades")) -> MaterialFit:
    """The material whose stresses are nearest to those of tests: rows of a stretch, or an amount of shear, and the
    nominal stress in Pa. goal: of the relative errors, "least_squares" or "largest_error". Constants not in `terms`
    are 0."""
    goals = ["least_squares", "largest_error"]
    bits = {"exponential": 1, "second": 2, "second_fades": 4}
    if goal not in goals or not set(terms) <= set(bits):
        raise Error(f"fit_material: expected a goal of {goals} and terms of {list(bits)}, got {goal!r} and {terms!r}")
    tables = [floats(table, (-1, 2), f"rows of strain and stress ({name})") if len(table) else np.empty((0, 2))
              for name, table in (("uniaxial", uniaxial), ("shear", shear))]
    kinds = integers(np.repeat([0, 1], [len(table) for table in tables]), 1, "kinds of tests")
    strains, stresses = np.ascontiguousarray(np.concatenate(tables).T)
    start, fitted = Material(0.0, poisson, density)._struct, sized("phymul_material")
    error, stress = ctypes.c_double(), np.empty(len(kinds))
    library.phymul_fit_material(ctypes.byref(start), kinds.ctypes.data, strains.ctypes.data, stresses.ctypes.data,
                                len(kinds), sum(bits[term] for term in set(terms)), goals.index(goal),
                                ctypes.byref(fitted), ctypes.byref(error), stress.ctypes.data)
    return MaterialFit(Material(fitted.young, poisson, density, **dict(zip(_stiffening, fitted.stiffening))), stress,
                       error.value)


class Body(Owner):
    """Particles with cells, groups and materials: `Model` in C++. Units are SI."""

    def __init__(self, handle: Handle) -> None:
        self._handle = handle

    @property
    def rest(self) -> np.ndarray:
        """[N][3] rest positions, m. A view, read-only; it stays valid, also after close()."""
        return view_of(library.phymul_body_rest, self._own, 3, "<f8")

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.rest)

    @property
    def masses(self) -> np.ndarray:
        """[N] kg. A copy."""
        masses = np.empty(self.particles)
        library.phymul_body_masses(self._pointer, masses.ctypes.data)
        return masses

    @property
    def triangles(self) -> np.ndarray:
        """[n][3] rows of particles: the body's surface, counter-clockwise seen from outside. A view, read-only."""
        return view_of(library.phymul_body_triangles, self._own, 3, "<i4")

    @property
    def _cell_lists(self) -> tuple[np.ndarray, np.ndarray]:
        """[cells + 1] where each cell's particles begin, and all their particles. Copies."""
        out = [ctypes.c_void_p() for _ in range(3)]
        count = ctypes.c_int32()
        library.phymul_body_cells(self._pointer, *(ctypes.byref(place) for place in out), ctypes.byref(count))
        first = view(out[1].value, (count.value + 1,), "<i4", self._own).copy()
        return first, view(out[2].value, (int(first[-1]),), "<i4", self._own).copy()

    @property
    def cells(self) -> list[np.ndarray]:
        """Particles of each cell. Copies."""
        first, particles = self._cell_lists
        return np.split(particles, first[1:-1]) if len(first) > 1 else []

    @property
    def cell_centres(self) -> np.ndarray:
        """[cells][3] m, means of the cells' particles at rest."""
        rest = self.rest
        return np.array([rest[cell].mean(axis=0) for cell in self.cells]).reshape(-1, 3)

    @property
    def groups(self) -> list[str]:
        return lines_of(library.phymul_body_groups, self._pointer)

    @property
    def notes(self) -> list[str]:
        """What reading, building and set_material found or corrected."""
        return lines_of(library.phymul_body_notes, self._pointer)

    def group(self, name: str) -> np.ndarray:
        """[n] particles of a group, sorted. A copy."""

        def find(body: int, rows: Any, count: Any) -> None:
            library.phymul_body_group(body, name, rows, count)

        return view_of(find, self._own, 1, "<i4").copy()

    def add_group(self, name: str, particles: Any) -> None:
        """Rows of particles, or a mask of N booleans: `body.add_group("held", body.rest[:, 2] < 0.01)`."""
        rows = self._rows(particles, f'group "{name}"')
        library.phymul_body_add_group(self._pointer, name, rows.ctypes.data, len(rows))

    def add_cell_group(self, name: str, cells: Any) -> None:
        """Rows of cells, or a mask. set_material gives a material to exactly these."""
        rows = rows_of(cells, len(self.cells), f'group "{name}"')
        library.phymul_body_add_cell_group(self._pointer, name, rows.ctypes.data, len(rows))

    def within(self, centre: Vector, radius: float) -> np.ndarray:
        """Mask of the particles at most `radius`, m, from a place at rest. Spare particles are nowhere."""
        return (np.linalg.norm(self.rest - floats(centre, (3,), "a centre"), axis=1) <= radius) & ~self._spare

    @property
    def _spare(self) -> np.ndarray:
        """Mask of the particles that wait for cuts: without mass, behind those of all cells."""
        cells = self._cell_lists[1]
        spare = (self.masses == 0) & (len(cells) > 0)
        spare[: cells.max(initial=-1) + 1] = False
        return spare

    def _rows(self, chosen: Any, what: str) -> np.ndarray:
        """Of particles by number, or by a mask, which never means spare ones: they lie where particle 0 does."""
        rows = rows_of(chosen, self.particles, what)
        return rows[~self._spare[rows]] if np.asarray(chosen).dtype == bool else rows

    def set_material(self, young: float, poisson: float, density: float, group: Optional[str] = None,
                     **further: float) -> Material:
        """Pa, 1, kg/m^3, and the other constants of Material by name; of the whole body, or of the cells of a group.
        Masses follow from the density."""
        material = Material(young, poisson, density, **further)
        library.phymul_body_set_material(self._pointer, ctypes.byref(material._struct),
                                         group)
        return material

    def add_capsule(self, material: Material) -> None:
        """Gives the outer faces of the cells a wall on the body's own particles."""
        library.phymul_body_add_capsule(self._pointer, ctypes.byref(material._struct))

    def cut(self, point: Vector, normal: Vector, front: Optional[tuple[Vector, Vector]] = None) -> Body:
        """A body of tetrahedra, cut along a plane; where `front`, a point and a normal, is given, only behind it. Set
        materials before. The faces of the cut touch under contacts."""
        return Body(make("body", cut_along, library.phymul_body_cut, self._pointer, point, normal, front))

    @property
    def parts(self) -> tuple[np.ndarray, np.ndarray]:
        """Pieces that hang together: [N] the number of each particle's piece, -1: none, and their volumes, m^3."""
        address, volumes, counts = ctypes.c_void_p(), ctypes.c_void_p(), (ctypes.c_int32(), ctypes.c_int32())
        library.phymul_body_parts(self._pointer, *map(ctypes.byref, (address, counts[0], volumes, counts[1])))
        return (view(address.value, (counts[0].value,), "<i4", self._own).copy(),
                view(volumes.value, (counts[1].value,), "<f8", self._own).copy())

    def with_spare_particles(self, count: int) -> Body:
        """The same body with room for the copies of so many particles, which Simulation.cut and blades need."""
        return Body(make("body", library.phymul_body_with_spare_particles, self._pointer, count))

    def moved(self, by: Vector) -> Body:
        """The same body elsewhere."""
        by = floats(by, (3,), "a displacement")
        return Body(make("body", library.phymul_body_moved, self._pointer, by.ctypes.data))


def make_block(size: Vector, nx: int, ny: int, nz: int) -> Body:
    """A box of hexahedra from the origin. Groups: x0, x1, y0, y1, z0, z1."""
    size = floats(size, (3,), "a size")
    return Body(make("body", library.phymul_body_block, size.ctypes.data, nx, ny, nz))


def make_tetrahedral_block(size: Vector, nx: int, ny: int, nz: int, jitter: float = 0.2, seed: int = 1) -> Body:
    """The same of unstructured tetrahedra; `jitter` in spacings."""
    size = floats(size, (3,), "a size")
    return Body(make("body", library.phymul_body_tetrahedral_block, size.ctypes.data, nx, ny, nz, jitter, seed))


def make_cylinder(radius: float, length: float, rings: int, sectors: int, discs: int) -> Body:
    """On the z axis. Groups: bottom, top, side."""
    return Body(make("body", library.phymul_body_cylinder, radius, length, rings, sectors, discs))


def read_body(path: Path, metres_per_unit: Optional[float] = None) -> Body:
    """A .pml file (millimetres unless said otherwise), or a mesh: .msh, .vtk, .vtu (metres)."""
    return Body(make("body", library.phymul_body_read, path_of(path),
                     0.0 if metres_per_unit is None else other_than_zero(metres_per_unit, "metres_per_unit")))


def read_surface(path: Path, metres_per_unit: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Vertices [n][3], m, and triangles [m][3] of an STL, OBJ, PLY or glTF file, mended. Views, read-only."""
    handle = make("surface", library.phymul_surface_read, path_of(path),
                  other_than_zero(metres_per_unit, "metres_per_unit"))
    return (view_of(library.phymul_surface_vertices, handle, 3, "<f8"),
            view_of(library.phymul_surface_triangles, handle, 3, "<i4"))


def make_body(vertices: Any, triangles: Any, spacing: float, fine: Sequence[tuple[Vector, float, float]] = ()) -> Body:
    """Fills a closed surface with tetrahedra about `spacing`, m, apart. Group: surface. fine: places around which the
    body is finer, each with a radius and the spacing within it, m."""
    vertices = floats(vertices, (-1, 3), "vertices")
    triangles = integers(triangles, 3, "triangles")
    place = structs["phymul_fine_place"]
    places = (place * len(fine))(*(place((ctypes.c_double * 3)(*floats(at, (3,), "a place")), radius, own)
                                   for at, radius, own in fine))
    return Body(make("body", library.phymul_body_fill, vertices.ctypes.data, len(vertices), triangles.ctypes.data,
                     len(triangles), spacing, places, len(fine)))


def make_wall(vertices: Any, triangles: Any, material: Material, spacing: float = 0.0) -> Body:
    """A wall of a material with a thickness, with the surface as its middle. No side of a triangle is longer than 1.4
    times the spacing, m; 0: as they are."""
    vertices = floats(vertices, (-1, 3), "vertices")
    triangles = integers(triangles, 3, "triangles")
    return Body(make("body", library.phymul_body_wall, vertices.ctypes.data, len(vertices), triangles.ctypes.data,
                     len(triangles), spacing, ctypes.byref(material._struct)))


def body_from_arrays(rest: Any, cells: Optional[dict[str, Any]] = None) -> Body:
    """From particles [N][3], m, and cells by type: `{"tetrahedron": [n][4]}`, also wedge, pyramid, hexahedron, with the
    order of vertices of VTK but for the wedge. Without cells: a body of points with 20 neighbours each."""
    rest = floats(rest, (-1, 3), "particles")
    types: list[int] = []
    rows: list[np.ndarray] = [np.zeros(0, np.int32)]
    sizes: list[int] = []
    for name, list_of_cells in (cells or {}).items():
        if name not in _sizes:
            raise Error(f'cells: expected the types {", ".join(_sizes)}; got "{name}"')
        array = integers(list_of_cells, _sizes[name], f"cells of the type {name}")
        types += [constants[name.upper()]] * len(array)
        sizes += [_sizes[name]] * len(array)
        rows.append(array.ravel())
    type_array, particles = np.array(types, np.int32), np.concatenate(rows)
    first = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
    return Body(make("body", library.phymul_body_from_arrays, rest.ctypes.data, len(rest), type_array.ctypes.data,
                     first.ctypes.data, particles.ctypes.data, len(types)))
