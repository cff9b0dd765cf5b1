# SPDX-License-Identifier: MIT
"""What acts on a simulation or follows it: loads, tools, joints, skins."""

from __future__ import annotations

import ctypes
import sys
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Optional, Sequence, Union

import numpy as np

from ._library import Error, ErrorCode, Handle, Owner, floats, library, make, sized, view
from .body import Vector

if TYPE_CHECKING:
    from .scene import Scene

Where = Any  # the name of a group, rows of particles, or a mask of N booleans
Value = Union[float, Sequence[tuple[float, float]]]  # constant, or pairs of a time, s, and a value, linear between
_ref = ctypes.byref


@dataclass(frozen=True)
class Sphere:
    radius: float  # m


@dataclass(frozen=True)
class Capsule:
    """All within `radius` of the segment from the tool's position along its z axis."""

    radius: float  # m
    length: float  # m


@dataclass(frozen=True)
class HalfSpace:
    """Solid below the tool's position: a floor."""


@dataclass(frozen=True)
class Box:
    half_size: Vector  # m


@dataclass(frozen=True)
class Blade:
    """An edge along the tool's x axis, which cuts toward -z, straight or an arc (include/phymul/blade.h)."""

    width: float  # m
    toughness: float = 0.0  # J/m^2
    belly: float = 0.0  # m
    bow: float = 0.0  # m
    height: float = 0.0  # m, of its sides
    friction: float = 0.0  # N/m^2, of these


@dataclass(frozen=True)
class Needle:
    """A shaft that punctures. Straight from the tip, the tool's position, along its z axis, or an arc toward x. Limits
    of forces, so that a force curve depends neither on step nor on speed (docs/guide/needles.md)."""

    length: float = 0.15  # m
    radius: float = 0.64e-3  # m
    puncture: float = 2.0  # N
    cutting: float = 0.9  # N
    static_friction: float = 15.0  # N/m
    kinetic_friction: float = 10.0  # N/m
    spread: float = 0.0  # m; 0: 34 radii, at least two spacings
    bending_stiffness: float = 0.0  # N m^2; 0: stiff
    arc_radius: float = 0.0  # m; 0: straight
    leaving: float = 0.0  # N


@dataclass(frozen=True)
class NeedleState:
    nodes: int  # of the holes; 0: no contact
    punctured: bool
    through: bool  # the tip came out again
    is_free: bool  # let go
    slip: float  # m by which the tip has gone beyond the last node


Shape = Union[Sphere, Capsule, HalfSpace, Box, Blade, Needle]


@dataclass(frozen=True)
class Pose:
    position: Vector = (0.0, 0.0, 0.0)  # m
    orientation: Vector = (1.0, 0.0, 0.0, 0.0)  # quaternion w, x, y, z
    velocity: Vector = (0.0, 0.0, 0.0)  # m/s, of the tool after the call, until it gets a new pose
    spin: Vector = (0.0, 0.0, 0.0)  # rad/s


@dataclass(frozen=True)
class ToolForce:
    """Of the particles on the tool: N, and N m about its position. Means are over the steps of the last call."""

    force: np.ndarray
    torque: np.ndarray
    mean_force: np.ndarray
    mean_torque: np.ndarray
    particles: int
    held: int


@dataclass(frozen=True)
class JointReport:
    force: np.ndarray  # N, sum over the springs
    largest: float  # N, of a spring
    broken: int
    springs: int


@dataclass(frozen=True)
class Anchor:
    """An end of a spring: the mean of `particles`, else a `point`, m, of the world or in the frame of `tool`."""

    particles: Where = None
    point: Vector = (0.0, 0.0, 0.0)
    tool: Optional[Tool] = None

    def __post_init__(self) -> None:
        if self.particles is not None and self.tool is not None:
            raise Error("an anchor: expected particles or a tool, got both")


def fill(struct: Any, what: str, **vectors: Any) -> Any:
    for name, values in vectors.items():
        place = getattr(struct, name)
        place[:] = floats(values, (len(place),), f"{what}: {name}").tolist()
    return struct


def fields_of(struct: Any) -> dict[str, Any]:
    values = {name: getattr(struct, name) for name, _ in struct._fields_ if name != "size"}
    return {name: np.array(value) if hasattr(value, "__len__") else value for name, value in values.items()}


def constants_of(struct: str, values: Any) -> Any:
    """A struct in which 0 stands for the default and -1 for 0. Throws Error for numbers below 0."""
    numbers = {}
    for field in fields(values):
        value = getattr(values, field.name)
        if value is not None and value < 0:
            raise Error(f"{type(values).__name__}.{field.name}: expected 0 or more, got {value!r:.100}")
        numbers[field.name] = 0.0 if value is None else -1.0 if value == 0 and field.default != 0 else value
    return sized(struct, **numbers)


def pose_of(pose: Pose) -> Any:
    if not np.any(pose.orientation):  # which is none in C
        raise Error(f"a pose: expected an orientation other than 0, got {pose.orientation!r:.100}")
    return fill(sized("phymul_pose"), "a pose", position=pose.position, orientation=pose.orientation,
                 velocity=pose.velocity, spin=pose.spin)


def events_of(value: Value) -> np.ndarray:
    """[2][n]: times and values."""
    if np.isscalar(value) or getattr(value, "shape", None) == ():
        value = [(-sys.float_info.max, value)]  # before its first time a value is 0
    return np.ascontiguousarray(floats(value, (-1, 2), "a value: a number, or pairs of time and value").T)


class Numbered:
    """What a simulation has under a number."""

    def __init__(self, simulation: Scene, number: int) -> None:
        self._simulation, self._number = simulation, number

    def _call(self, function: Any, *arguments: Any) -> None:
        function(self._simulation._pointer, self._number, *arguments)


class Load(Numbered):
    """A load of a simulation; set() changes its value, as often as you like."""

    def __init__(self, simulation: Scene, number: int) -> None:
        super().__init__(simulation, number)
        self._replays = simulation._replays

    def set(self, value: Value) -> None:
        if self._replays != self._simulation._replays:
            raise Error("this load is gone: replay() cleared the scene", ErrorCode.UNKNOWN_NAME)
        events = events_of(value)
        self._call(library.phymul_set_load, events[0].ctypes.data, events[1].ctypes.data, events.shape[1])


class Tool(Numbered):
    """A rigid tool of a simulation."""

    def _number_in(self, simulation: Scene) -> int:
        if self._simulation is not simulation:
            raise Error("expected a tool of this simulation, got one of another")
        return self._number

    def move_to(self, pose: Pose) -> None:
        """Moves there during the next step or advance."""
        self._call(library.phymul_tool_move_to, _ref(pose_of(pose)))

    def teleport(self, pose: Pose) -> None:
        """Puts it there at once, without passing the space between."""
        self._call(library.phymul_tool_teleport, _ref(pose_of(pose)))

    def grasp(self, distance: float) -> None:
        """From the next step on particles within a distance, m, move with the tool."""
        self._call(library.phymul_tool_grasp, distance)

    def release(self) -> None:
        self._call(library.phymul_tool_release)

    def remove(self) -> None:
        self._call(library.phymul_tool_remove)

    @property
    def pose(self) -> Pose:
        pose = sized("phymul_pose")
        self._call(library.phymul_tool_read_pose, _ref(pose))
        return Pose(**fields_of(pose))

    @property
    def force(self) -> ToolForce:
        force = sized("phymul_tool_force")
        self._call(library.phymul_tool_read_force, _ref(force))
        return ToolForce(**fields_of(force))

    @property
    def needle(self) -> NeedleState:
        """Throws Error for another shape."""
        state = sized("phymul_needle_state")
        self._call(library.phymul_needle_read, _ref(state))
        flags = {name: bool(getattr(state, name)) for name in ("punctured", "through", "is_free")}
        return NeedleState(**{**fields_of(state), **flags})

    def needle_points(self, count: int) -> np.ndarray:
        """[count][3] points of a needle's shaft from tip to hub, m."""
        points = np.zeros((max(count, 0), 3))
        self._call(library.phymul_needle_points, count, points.ctypes.data)
        return points


@dataclass(frozen=True)
class JawsOptions:
    """As Scene.add_jaws has them: there, and in C, is the default of each, which is not 0."""

    length: float
    width: float
    thickness: float
    friction: float
    grip: float
    opening: float
    speed: float


@dataclass(frozen=True)
class JawsReport:
    """Of the tick before: N, and N m about the hinge, on the handle."""

    angle: float  # rad, between the plates
    grip: float  # N at the end of a plate
    force: np.ndarray
    torque: np.ndarray


class Jaws:
    """A grasper that holds by friction: Simulation.add_jaws makes it. Call follow() once before each advance()."""

    def __init__(self, simulation: Scene, handle: Handle) -> None:
        self._simulation, self._handle = simulation, handle
        first, second = self._read().plates
        self.first, self.second = Tool(simulation, first), Tool(simulation, second)

    def _read(self) -> Any:
        report = sized("phymul_jaws_report")
        library.phymul_jaws_read(self._handle.pointer, self._simulation._pointer, _ref(report))
        return report

    def close(self) -> None:
        """From the next follow() on."""
        library.phymul_jaws_close(self._handle.pointer, 1)

    def open(self) -> None:
        library.phymul_jaws_close(self._handle.pointer, 0)

    def follow(self, hinge: Pose, dt: float) -> None:
        """Moves both plates to where they are at the end of a tick of `dt`, s, in which the hinge goes to a pose."""
        library.phymul_jaws_follow(self._handle.pointer, self._simulation._pointer, _ref(pose_of(hinge)), dt)

    @property
    def report(self) -> JawsReport:
        values = fields_of(self._read())
        del values["plates"]
        return JawsReport(**values)


class Joint(Numbered):
    """A joint of a simulation."""

    def set_stiffness(self, stiffness: float, damping: float = 0.0) -> None:
        self._call(library.phymul_joint_set, stiffness, damping)

    def remove(self) -> None:
        self._call(library.phymul_joint_remove)

    @property
    def report(self) -> JointReport:
        report = sized("phymul_joint_report")
        self._call(library.phymul_joint_read, _ref(report))
        return JointReport(**fields_of(report))


class Skin(Owner):
    """Points that move with the body of a simulation: Scene.bind makes it."""

    def __init__(self, simulation: Scene, points: np.ndarray, triangles: np.ndarray) -> None:
        self._simulation, self._points = simulation, len(points)
        self._handle = make("skin", library.phymul_skin_create, simulation._pointer, points.ctypes.data, len(points),
                            triangles.ctypes.data, len(triangles))

    def deform(self) -> tuple[np.ndarray, np.ndarray]:
        """[n][3] places, m, and unit normals (0 without triangles) where the body is now: read-only views that the next
        call overwrites."""

        out = [ctypes.c_void_p(), ctypes.c_void_p()]
        library.phymul_skin_deform(self._pointer, self._simulation._pointer, _ref(out[0]), _ref(out[1]))
        points, normals = (view(place.value, (self._points, 3), "<f8", self._own) for place in out)
        return points, normals
