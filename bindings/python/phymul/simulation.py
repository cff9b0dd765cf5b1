# SPDX-License-Identifier: MIT
"""Simulations: a body in time, or at rest."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Union

import numpy as np

from ._library import (Error, ErrorCode, Handle, Owner, cut_along, encoded, floats, instance, library, lines_of, make,
                       other_than_zero, path_of, rows_of, sized, text_of, view_of)
from .body import Body, Material, Path, Vector
from .interaction import fields_of
from .scene import Scene

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
    springs_broken: int  # in this call, as the next three
    tissue_gave_way: int  # punctures below the needle's own force
    uncut: int  # cells that a blade has passed, or that should have torn, and that could not part
    torn: int  # cells
    cut_later: int  # cells that blades have passed and that wait for their cuts (tick_budget)
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

    def __reduce__(self) -> Any:  # without it a process that gets one from another cannot make it
        return StepError, (str(self), self.report)


@dataclass(frozen=True)
class Energy:
    """J."""

    elastic: float
    kinetic: float
    gravity: float

    @property
    def total(self) -> float:
        return self.elastic + self.kinetic + self.gravity


class Simulation(Scene):
    """A body, or several by name, with what acts on it: `Simulation` in C++. Units are SI.

    One thread at a time may use it. The solver is made by the first function that needs it: add tools and loads before,
    so that the backend "auto" can choose by them."""

    def __init__(self, body: Union[Body, Mapping[str, Body]], *, young: float = 0.0, poisson: float = 0.0,
                 density: float = 0.0, backend: str = "auto", damping: float = 0.0, step: float = 0.0, threads: int = 0,
                 rest_tolerance: float = 1e-8, sleep_tolerance: Optional[float] = None, tick_budget: int = 0) -> None:
        """young: Pa, density: kg/m^3; left out, bodies keep their materials. damping: 1/s. step: largest one, as a
        multiple of the stable step; 0: it follows the deformation. threads: of the backend "cpu", 0: as many as the
        body has work for. tick_budget: cells that blades cut at most in a call of advance(), 0: all."""
        self._handle: Optional[Handle] = None
        options = sized("phymul_options", threads=threads, backend=backend, damping_rate=damping, step=step,
                         rest_tolerance=other_than_zero(rest_tolerance, "rest_tolerance"),
                         sleeps=sleep_tolerance is not None,
                         sleep_tolerance=sleep_tolerance or 0.0, tick_budget=tick_budget)
        material = Material(young, poisson, density)
        material_struct = material._struct
        if material != Material(0.0, 0.0, 0.0):
            options.material = ctypes.addressof(material_struct)
        bodies = [instance(each, Body, "a body") for each in (body.values() if isinstance(body, Mapping) else [body])]
        handles = (ctypes.c_void_p * len(bodies))(*(each._pointer for each in bodies))
        names = None
        if isinstance(body, Mapping):
            names = (ctypes.c_char_p * len(bodies))(*map(encoded, body))
        self._handle = make("simulation", library.phymul_simulation_create, handles, names, len(bodies), _ref(options))
        self._body: Optional[Body] = None
        self._body_cuts = 0

    @classmethod
    def _of(cls, handle: Handle) -> Simulation:
        made = cls.__new__(cls)
        made._handle, made._body, made._body_cuts = handle, None, 0
        return made

    @property
    def body(self) -> Body:
        """A copy of the body, or of all bodies as one, with their materials; the same one until cells are cut."""
        # Blades cut, and tissue tears, in a step.
        if self._body is None or self._body._handle is None or self._body_cuts != self.cuts:
            self._body_cuts = self.cuts
            self._body = Body(make("body", library.phymul_simulation_body, self._pointer))
        return self._body

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
        whether = ctypes.c_int32()
        cut_along(library.phymul_cut, self._pointer, point, normal, front, _ref(whether))
        self._body = None
        return bool(whether.value)

    @property
    def cuts(self) -> int:
        """How many cuts the body has, by cut(), blades and tears."""
        count = ctypes.c_int32()
        library.phymul_cuts(self._pointer, _ref(count))
        return count.value

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
        del fields["unused"]
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

    def solve_static(self, tolerance: float = 1e-6, most_evaluations: int = 3000, predict: bool = False) -> RestReport:
        """The rest shape without steps, for scenes without contacts. Ask whether it `converged`. With `predict` the
        search begins where the last calls lead, for loads and tools that change little by little."""
        function = library.phymul_follow_static if predict else library.phymul_solve_static
        return self._rested(function, other_than_zero(tolerance, "tolerance"),
                            other_than_zero(most_evaluations, "most_evaluations"))

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
        return lines_of(library.phymul_warnings, self._pointer)

    # States

    def set_state(self, positions: Any = None, velocities: Any = None, time: float = 0.0) -> None:
        """Starts from [N][3] positions, m (left out: at rest), and velocities, m/s (left out: 0). Tools let go."""
        shape = (self.body.particles, 3)
        arrays = [None if values is None else floats(values, shape, what)
                  for values, what in ((positions, "positions"), (velocities, "velocities"))]
        library.phymul_set_state(self._pointer, time, *(None if each is None else each.ctypes.data for each in arrays))

    def snapshot(self) -> Snapshot:
        """The state with all that further steps depend on, tools, joints and threads too. restore() leaves loads,
        gravity, contacts, kept volumes, tearing and factors of stiffness as they are."""
        return Snapshot(make("snapshot", library.phymul_snapshot_take, self._pointer))

    def restore(self, snapshot: Snapshot) -> None:
        library.phymul_snapshot_restore(instance(snapshot, Snapshot, "a snapshot")._pointer, self._pointer)
        self._body = None  # cells may have come back

    def save(self, path: Path) -> None:
        """The state, to a file."""
        library.phymul_save(self._pointer, path_of(path))

    def load(self, path: Path) -> None:
        library.phymul_load(self._pointer, path_of(path))
        self._body = None

    def record(self) -> None:
        """From now on what is done with this simulation is recorded. Poses and grasps that no step has followed yet are
        dropped: repeat them."""
        library.phymul_record(self._pointer)

    def save_recording(self, path: Path) -> None:
        library.phymul_save_recording(self._pointer, path_of(path))

    def replay(self, path: Path) -> None:
        """Clears the scene and repeats a recording. Loads, tools and joints from before are gone, unless it is refused
        at its start, as one of another body."""
        try:
            library.phymul_replay(self._pointer, path_of(path))
        except Error as error:
            self._replays += "Replay: input " in str(error)  # later than its start
            raise
        finally:
            self._body = None
        self._replays += 1

    def write_vtu(self, path: Path) -> None:
        """For ParaView."""
        library.phymul_write_vtu(self._pointer, path_of(path))


class Snapshot(Owner):
    def __init__(self, handle: Handle) -> None:
        self._handle = handle
