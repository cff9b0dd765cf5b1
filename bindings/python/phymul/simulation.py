# SPDX-License-Identifier: MIT
"""Simulations: a body in time, or at rest."""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Union

import numpy as np

from ._library import (Error, ErrorCode, Handle, Owner, constants, floats, integers, library, make, path_of, rows_of,
                       sized, text_of, view_of)
from .body import Body, Material, Path, Vector
from .interaction import (Anchor, Blade, Box, Capsule, HalfSpace, Joint, Load, Pose, Shape, Skin, Sphere, Tool, Value, Where,
                          events_of, fields_of, fill, pose_of)

_ref = ctypes.byref


@dataclass(frozen=True)
class StepReport:
    steps: int
    at_rest: bool
    force_clamped: bool
    particle: int  # where a failure happened; -1: unknown
    time: float  # s
    dt: float  # s
    stable_step: float  # s
    residual: float  # N, largest net force on a free particle
    max_speed: float  # m/s
    message: str


@dataclass(frozen=True)
class RestReport:
    converged: bool
    folded: int  # a cell that is flat or turned inside out; -1: none
    steps: int  # solve_static: evaluations of forces
    collapsed: int  # particle with a collapsed base; -1: none
    time: float  # s
    residual: float  # N; solve_static: net forces over loads
    message: str


class StepError(Error):
    """A step failed; the simulation keeps its last good state. `report` says more."""

    def __init__(self, message: str, report: StepReport) -> None:
        super().__init__(message, ErrorCode.STEP_FAILED)
        self.report = report


@dataclass(frozen=True)
class Energy:
    """J."""

    elastic: float
    kinetic: float
    gravity: float

    @property
    def total(self) -> float:
        return self.elastic + self.kinetic + self.gravity


class Simulation(Owner):
    """A body, or several by name, with what acts on it: `Simulation` in C++. Units are SI.

    One thread at a time may use it. The solver is made by the first function that needs it: add tools and loads before,
    so that the backend "auto" can choose by them."""

    def __init__(self, body: Union[Body, Mapping[str, Body]], *, young: float = 0.0, poisson: float = 0.0,
                 density: float = 0.0, backend: str = "auto", damping: float = 0.0, step: float = 0.0, threads: int = 0,
                 rest_tolerance: float = 1e-8, sleep_tolerance: Optional[float] = None) -> None:
        """young: Pa, density: kg/m^3; left out, bodies keep their materials. damping: 1/s. step: largest one, as a
        multiple of the stable step; 0: it follows the deformation. threads: of the backend "cpu", 0: as many as the body has work for."""
        self._handle: Optional[Handle] = None
        options = sized("phymul_options", threads=threads, backend=backend.encode(), damping_rate=damping, step=step,
                         rest_tolerance=rest_tolerance, sleeps=sleep_tolerance is not None,
                         sleep_tolerance=sleep_tolerance or 0.0)
        material = Material(young, poisson, density)
        material_struct = material._struct
        if material != Material(0.0, 0.0, 0.0):
            options.material = ctypes.addressof(material_struct)
        bodies = [body] if isinstance(body, Body) else list(body.values())
        handles = (ctypes.c_void_p * len(bodies))(*(each._pointer for each in bodies))
        names = None
        if not isinstance(body, Body):
            names = (ctypes.c_char_p * len(bodies))(*(name.encode() for name in body))
        self._handle = make("simulation", library.phymul_simulation_create, handles, names, len(bodies), _ref(options))
        self._body: Optional[Body] = None

    @classmethod
    def _of(cls, handle: Handle) -> Simulation:
        made = cls.__new__(cls)
        made._handle, made._body = handle, None
        return made

    @property
    def body(self) -> Body:
        """A copy of the body, or of all bodies as one, with their materials."""
        if self._body is None:
            self._body = Body(make("body", library.phymul_simulation_body, self._pointer))
        return self._body

    def _rows(self, where: Where) -> np.ndarray:
        return self.body.group(where) if isinstance(where, str) else rows_of(where, self.body.particles, "particles")

    # What acts on it

    def fix(self, where: Where) -> Simulation:
        """Holds a group, rows of particles or a mask of particles at rest."""
        rows = self._rows(where)
        library.phymul_fix_particles(self._pointer, rows.ctypes.data, len(rows))
        return self

    def scale_stiffness(self, factor: float, material: Optional[Material] = None) -> Simulation:
        """Of a material of the body as Body.set_material returned it, or of all; always of its own stiffness."""
        struct = _ref(material._struct) if material else None
        library.phymul_scale_stiffness(self._pointer, struct, factor)
        return self

    def gravity(self, acceleration: Vector) -> Simulation:
        """m/s^2."""
        vector = floats(acceleration, (3,), "an acceleration")
        library.phymul_gravity(self._pointer, vector.ctypes.data)
        return self

    def add_load(self, kind: str, where: Where, direction: Vector = (0.0, 0.0, 0.0), value: Value = 0.0) -> Load:
        """kind: "force" (N, on each particle), "pressure" (Pa, inward without a direction), "acceleration" (m/s^2),
        "translation" (m) or "rotation" (rad, about the direction); the last two impose positions."""
        kinds = ("translation", "rotation", "force", "pressure", "acceleration")
        if kind not in kinds:
            raise Error(f'expected a load of {", ".join(kinds)}; got "{kind}"')
        rows, events, row = self._rows(where), events_of(value), ctypes.c_int32()
        vector = floats(direction, (3,), "a direction")
        library.phymul_add_load(self._pointer, constants[kind.upper()], rows.ctypes.data, len(rows), vector.ctypes.data,
                                events[0].ctypes.data, events[1].ctypes.data, events.shape[1], _ref(row))
        return Load(self, row.value)

    def contacts(self, friction: float = 0.3, margin: float = 0.0, self_contact: bool = True) -> Simulation:
        """Bodies touch each other, and parts of one body."""
        library.phymul_contacts(self._pointer, friction, margin, self_contact)
        return self

    def constrain_volume(self, group: Optional[str] = None) -> Simulation:
        """Keeps the volume of a group, or of the whole body, at its rest value."""
        library.phymul_constrain_volume(self._pointer, group.encode() if group else None)
        return self

    def add_tool(self, shape: Shape, pose: Pose = Pose(), *, friction: float = 0.0, compliance: float = 0.0,
                 margin: float = 0.0, contact: str = "particles") -> Tool:
        """contact: "particles" or "surface". compliance: m/N, margin: m."""
        if contact not in ("particles", "surface"):
            raise Error(f'expected the contact "particles" or "surface", got "{contact}"')
        pose_struct = pose_of(pose)
        options = sized("phymul_tool_options", friction=friction, compliance=compliance, margin=margin,
                        contact=contact == "surface", pose=ctypes.addressof(pose_struct))
        kinds = {Sphere: "SPHERE", Capsule: "CAPSULE", HalfSpace: "HALF_SPACE", Box: "BOX", Blade: "BLADE"}
        if type(shape) not in kinds:
            raise Error(f"expected a Sphere, Capsule, HalfSpace, Box or Blade, got {shape!r:.100}")
        options.shape = constants[kinds[type(shape)]]
        if isinstance(shape, (Sphere, Capsule)):
            options.radius = shape.radius
        if isinstance(shape, Capsule):
            options.length = shape.length
        if isinstance(shape, Blade):
            options.length, options.toughness = shape.width, shape.toughness
        if isinstance(shape, Box):
            fill(options, "a box", half_size=shape.half_size)
        number = ctypes.c_uint64()
        library.phymul_tool_add(self._pointer, _ref(options), _ref(number))
        return Tool(self, number.value)

    def add_joint(self, a: Anchor, b: Anchor, stiffness: float, damping: float = 0.0, *, slack: bool = False,
                  breaking_force: float = math.inf, rest_length: Optional[float] = None) -> Joint:
        """A spring with a damper, N/m and N s/m. rest_length: m; left out, the distance of the anchors when added."""
        kept, anchors = [], []
        for anchor in (a, b):
            struct = fill(sized("phymul_anchor"), "an anchor", point=anchor.point)
            if anchor.particles is not None:
                kept.append(self._rows(anchor.particles))
                struct.particles, struct.count = kept[-1].ctypes.data, len(kept[-1])
            elif anchor.tool is not None:
                struct.tool = anchor.tool._number_in(self)
            anchors.append(struct)
        options = sized("phymul_joint_options", slack=slack, stiffness=stiffness, damping=damping,
                         breaking=breaking_force, rest_length=-1.0 if rest_length is None else rest_length)
        number = ctypes.c_uint64()
        library.phymul_joint_add(self._pointer, _ref(anchors[0]), _ref(anchors[1]), _ref(options), _ref(number))
        return Joint(self, number.value)

    def attach(self, where: Where, to: Union[str, Tool, None] = None, *, stiffness: float, damping: float = 0.0,
               offset: Vector = (0.0, 0.0, 0.0), breaking_stress: float = math.inf, slack: bool = False) -> Joint:
        """A spring for each particle of a patch of the surface, to a body or group by name, to a tool, or to points of
        the world at `offset`, m, from the particles. N/m^3, N s/m^3, Pa: per area."""
        rows, vector = self._rows(where), floats(offset, (3,), "an offset")
        options = sized("phymul_joint_options", slack=slack, stiffness=stiffness, damping=damping,
                         breaking=breaking_stress)
        number = ctypes.c_uint64()
        library.phymul_attach(self._pointer, rows.ctypes.data, len(rows), to.encode() if isinstance(to, str) else None,
                              to._number_in(self) if isinstance(to, Tool) else 0, vector.ctypes.data, _ref(options),
                              _ref(number))
        return Joint(self, number.value)

    def hold_near(self, vertices: Any, triangles: Any, centre: Vector, radius: float, spacing: float) -> Joint:
        """Holds the part of a surface in a ball, in all directions, whatever particles lie there. The surface may be
        that which the body was made from; spacing, m: a third of the body's."""
        vertices, triangles = floats(vertices, (-1, 3), "vertices"), integers(triangles, 3, "triangles")
        middle, number = floats(centre, (3,), "a centre"), ctypes.c_uint64()
        library.phymul_hold_near(self._pointer, vertices.ctypes.data, len(vertices), triangles.ctypes.data,
                                 len(triangles), middle.ctypes.data, radius, spacing, _ref(number))
        return Joint(self, number.value)

    def add_body_types(self) -> list[str]:
        """Adds what the components of a .pml file are by their bodyType: springs, held bodies, contacts. Returns a
        sentence for each."""
        return text_of(library.phymul_add_body_types, self._pointer).splitlines()

    def bind(self, points: Any, triangles: Any = ()) -> Skin:
        """Points [n][3], m, that move with the body, such as the vertices of a finer surface; triangles for normals."""
        return Skin(self, floats(points, (-1, 3), "points"), integers(triangles, 3, "triangles"))

    # Time

    def remove_cells(self, cells: Any) -> Simulation:
        """Removes rows of cells, or a mask of them: `sim.remove_cells(sim.body.cell_centres[:, 2] > 0.02)`. Particles
        and cells keep their numbers; restore() brings cells back. Read `body` again for masses and surface."""
        rows = rows_of(cells, len(self.body.cells), "cells")
        library.phymul_remove_cells(self._pointer, rows.ctypes.data, len(rows))
        self._body = None
        return self

    def cut(self, point: Vector, normal: Vector, front: Optional[tuple[Vector, Vector]] = None) -> bool:
        """Cuts along a plane in the rest shape; where `front`, a point and a normal, is given, only behind it. Whether
        anything was cut. The body needs spare particles (Body.with_spare_particles); restore() undoes cuts. Read `body`
        again for masses, cells and surface."""
        plane = [floats(value, (3,), "a point or normal") for value in (point, normal, *(front or ()))]
        pointers = [value.ctypes.data for value in plane] + [None] * (4 - len(plane))
        whether = ctypes.c_int32()
        library.phymul_cut(self._pointer, *pointers, ctypes.byref(whether))
        self._body = None
        return bool(whether.value)

    def _stepped(self, function: Any, *arguments: Any) -> StepReport:
        report = sized("phymul_step_report")
        failure = None
        try:
            function(self._pointer, *arguments, _ref(report))
        except Error as error:
            if error.code != ErrorCode.STEP_FAILED:
                raise
            failure = error
        fields = fields_of(report)
        fields["at_rest"], fields["force_clamped"] = bool(report.at_rest), bool(report.force_clamped)
        result = StepReport(**fields, message=self.message)
        if failure:
            raise StepError(str(failure), result) from None
        return result

    def _rested(self, function: Any, *arguments: Any) -> RestReport:
        report = sized("phymul_rest_report")
        function(self._pointer, *arguments, _ref(report))
        fields = fields_of(report)
        fields["converged"] = bool(report.converged)
        return RestReport(**fields, message=self.message)

    def advance(self, seconds: float) -> StepReport:
        """Simulates `seconds` in equal steps. Throws StepError if a step fails."""
        return self._stepped(library.phymul_advance, seconds)

    def step(self, steps: int, dt: float) -> StepReport:
        """`steps` steps of dt, s. Throws StepError if one fails."""
        return self._stepped(library.phymul_step, steps, dt)

    def run_to_rest(self, most_steps: int = 200_000) -> RestReport:
        """Steps until the body is at rest. Ask the result whether it `converged`."""
        return self._rested(library.phymul_run_to_rest, most_steps)

    def solve_static(self, tolerance: float = 1e-6, most_evaluations: int = 3000) -> RestReport:
        """The rest shape without steps, for scenes without tools and contacts. Ask whether it `converged`."""
        return self._rested(library.phymul_solve_static, tolerance, most_evaluations)

    # What it is like now

    @property
    def positions(self) -> np.ndarray:
        """[N][3] m, now. This and the next two are read-only views of a buffer of the simulation: the next reading of
        the same property overwrites it. Take a copy() to compare two times."""
        return view_of(library.phymul_positions, self._own, 3, "<f8")

    @property
    def velocities(self) -> np.ndarray:
        """[N][3] m/s, now."""
        return view_of(library.phymul_velocities, self._own, 3, "<f8")

    @property
    def forces(self) -> np.ndarray:
        """[N][3] N, elastic forces on the particles, now."""
        return view_of(library.phymul_forces, self._own, 3, "<f8")

    @property
    def displacements(self) -> np.ndarray:
        """[N][3] m, from rest. A copy."""
        return self.positions - self.body.rest

    @property
    def time(self) -> float:
        """s."""
        time = ctypes.c_double()
        library.phymul_time(self._pointer, _ref(time))
        return time.value

    @property
    def energy(self) -> Energy:
        parts = (ctypes.c_double * 3)()
        library.phymul_energy(self._pointer, parts)
        return Energy(*parts)

    @property
    def stable_step(self) -> float:
        """s, the largest stable step."""
        stable, taken = ctypes.c_double(), ctypes.c_double()
        library.phymul_step_limits(self._pointer, _ref(stable), _ref(taken))
        return stable.value

    @property
    def backend(self) -> str:
        return text_of(library.phymul_backend, self._pointer)

    @property
    def message(self) -> str:
        """A sentence about the last step, run to rest or static solve."""
        return text_of(library.phymul_message, self._pointer)

    @property
    def warnings(self) -> list[str]:
        """What is probably not meant: suspect units, parts that nothing holds."""
        return text_of(library.phymul_warnings, self._pointer).splitlines()

    # States

    def set_state(self, positions: Any = None, velocities: Any = None, time: float = 0.0) -> None:
        """Starts from [N][3] positions, m (left out: at rest), and velocities, m/s (left out: 0). Tools let go."""
        shape = (self.body.particles, 3)
        arrays = [None if values is None else floats(values, shape, what)
                  for values, what in ((positions, "positions"), (velocities, "velocities"))]
        library.phymul_set_state(self._pointer, time, *(None if each is None else each.ctypes.data for each in arrays))

    def snapshot(self) -> Snapshot:
        """The state with all that further steps depend on, tools and joints too, except loads, gravity and contacts."""
        return Snapshot(make("snapshot", library.phymul_snapshot_take, self._pointer))

    def restore(self, snapshot: Snapshot) -> None:
        library.phymul_snapshot_restore(snapshot._pointer, self._pointer)
        self._body = None  # cells may have come back

    def save(self, path: Path) -> None:
        """The state, to a file."""
        library.phymul_save(self._pointer, path_of(path))

    def load(self, path: Path) -> None:
        library.phymul_load(self._pointer, path_of(path))
        self._body = None

    def record(self) -> None:
        """From now on what is done with this simulation is recorded."""
        library.phymul_record(self._pointer)

    def save_recording(self, path: Path) -> None:
        library.phymul_save_recording(self._pointer, path_of(path))

    def replay(self, path: Path) -> None:
        """Clears the scene and repeats a recording."""
        library.phymul_replay(self._pointer, path_of(path))
        self._body = None

    def write_vtu(self, path: Path) -> None:
        """For ParaView."""
        library.phymul_write_vtu(self._pointer, path_of(path))


class Snapshot(Owner):
    def __init__(self, handle: Handle) -> None:
        self._handle = handle
