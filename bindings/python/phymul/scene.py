# SPDX-License-Identifier: MIT
"""What acts on a body: the part of a simulation that is `Scene` in C++."""

from __future__ import annotations

import ctypes
import math
from typing import Any, Optional, TypeVar, Union

import numpy as np

from ._library import (Error, Owner, constants, floats, instance, integers, library, lines_of, make, other_than_zero,
                       sized)
from .body import Body, Material, Vector
from .interaction import (Anchor, Blade, Box, Capsule, HalfSpace, Jaws, JawsOptions, Joint, Load, Needle, Numbered,
                          Pose, Shape, Skin, Sphere, Tool, Value, Where, constants_of, events_of, fill, pose_of)
from .threads import Clip, Fluid, FluidState, Thread, ThreadHandle

_ref = ctypes.byref
Own = TypeVar("Own", bound="Scene")
Added = TypeVar("Added", bound=Numbered)


class Scene(Owner):
    """What acts on the body of a simulation: base of Simulation. Functions that return it can be chained."""

    _replays = 0  # each makes other loads

    @property
    def body(self) -> Body:
        raise NotImplementedError

    def _rows(self, where: Where) -> np.ndarray:
        return self.body.group(where) if isinstance(where, str) else self.body._rows(where, "particles")

    def _anchor(self, anchor: Anchor) -> tuple[Any, Any]:
        """The struct, and the particles that it points to."""
        struct = fill(sized("phymul_anchor"), "an anchor", point=anchor.point)
        rows = None
        if anchor.particles is not None:
            rows = self._rows(anchor.particles)
            struct.particles, struct.count = rows.ctypes.data, len(rows)
        elif anchor.tool is not None:
            struct.tool = anchor.tool._number_in(self)
        return struct, rows

    def _add(self, kind: type[Added], function: Any, *arguments: Any) -> Added:
        """Calls a function whose last parameter is where the number of what it adds goes."""
        number = ctypes.c_uint64()
        function(self._pointer, *arguments, _ref(number))
        return kind(self, number.value)

    def fix(self: Own, where: Where) -> Own:
        """Holds a group, rows of particles or a mask of particles at rest."""
        rows = self._rows(where)
        library.phymul_fix_particles(self._pointer, rows.ctypes.data, len(rows))
        return self

    def scale_stiffness(self: Own, factor: float, material: Optional[Material] = None) -> Own:
        """Of a material of the body as Body.set_material returned it, or of all; always of its own stiffness."""
        struct = _ref(material._struct) if material else None
        library.phymul_scale_stiffness(self._pointer, struct, factor)
        return self

    def gravity(self: Own, acceleration: Vector) -> Own:
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

    def contacts(self: Own, friction: float = 0.3, margin: float = 0.0, self_contact: bool = True) -> Own:
        """Bodies touch each other, and parts of one body."""
        library.phymul_contacts(self._pointer, friction, margin, self_contact)
        return self

    def constrain_volume(self: Own, group: Optional[str] = None) -> Own:
        """Keeps the volume of a group, or of the whole body, at its rest value."""
        library.phymul_constrain_volume(self._pointer, group)
        return self

    def add_tool(self, shape: Shape, pose: Pose = Pose(), *, friction: float = 0.0, compliance: float = 0.0,
                 margin: float = 0.0, contact: str = "particles", suction: float = 0.0,
                 suction_reach: float = 0.0) -> Tool:
        """contact: "particles" or "surface". compliance: m/N, margin: m, suction: N, suction_reach: m."""
        if contact not in ("particles", "surface"):
            raise Error(f'expected the contact "particles" or "surface", got "{contact}"')
        pose_struct = pose_of(pose)
        options = sized("phymul_tool_options", friction=friction, compliance=compliance, margin=margin,
                        contact=contact == "surface", pose=ctypes.addressof(pose_struct), suction=suction,
                        suction_reach=suction_reach)
        kinds = {Sphere: "SPHERE", Capsule: "CAPSULE", HalfSpace: "HALF_SPACE", Box: "BOX", Blade: "BLADE",
                 Needle: "NEEDLE"}
        if type(shape) not in kinds:
            raise Error(f"expected a Sphere, Capsule, HalfSpace, Box, Blade or Needle, got {shape!r:.100}")
        options.shape = constants[kinds[type(shape)]]
        if isinstance(shape, (Sphere, Capsule)):
            options.radius = shape.radius
        if isinstance(shape, Capsule):
            options.length = shape.length
        if isinstance(shape, Blade):
            options.length, options.toughness, options.side_friction = shape.width, shape.toughness, shape.friction
            options.belly, options.bow, options.height = shape.belly, shape.bow, shape.height
        if isinstance(shape, Needle):
            needle = constants_of("phymul_needle", shape)
            options.needle = ctypes.addressof(needle)
        if isinstance(shape, Box):
            fill(options, "a box", half_size=shape.half_size)
        return self._add(Tool, library.phymul_tool_add, _ref(options))

    def add_jaws(self, name: str, hinge: Pose = Pose(), *, length: float = 0.02, width: float = 0.006,
                 thickness: float = 0.006, friction: float = 0.5, grip: float = 1.0, opening: float = 0.6,
                 speed: float = 0.5, contact: str = "surface", toughness: Optional[float] = None) -> Jaws:
        """Two plates on a hinge, open: the tools "<name> 1" and "<name> 2". m; grip: N; opening: rad; speed: rad/s.
        toughness: J/m^2; scissors, two edges in place of the plates."""
        if contact not in ("particles", "surface"):
            raise Error(f'expected the contact "particles" or "surface", got "{contact}"')
        options = constants_of("phymul_jaws_options",
                               JawsOptions(length, width, thickness, friction, grip, opening, speed))
        options.touches_particles = contact == "particles"
        if toughness is not None:
            options.cuts, options.toughness = 1, toughness
        return Jaws(self, make("jaws", library.phymul_jaws_create, self._pointer, name, _ref(options),
                               _ref(pose_of(hinge))))

    def add_joint(self, a: Anchor, b: Anchor, stiffness: float, damping: float = 0.0, *, slack: bool = False,
                  breaking_force: float = math.inf, rest_length: Optional[float] = None) -> Joint:
        """A spring with a damper, N/m and N s/m. rest_length: m; left out, the distance of the anchors when added."""
        ends = [self._anchor(a), self._anchor(b)]
        options = sized("phymul_joint_options", slack=slack, stiffness=stiffness, damping=damping,
                         breaking=other_than_zero(breaking_force, "breaking_force"),
                         rest_length=-1.0 if rest_length is None else rest_length)
        return self._add(Joint, library.phymul_joint_add, _ref(ends[0][0]), _ref(ends[1][0]), _ref(options))

    def attach(self, where: Where, to: Union[str, Tool, None] = None, *, stiffness: float, damping: float = 0.0,
               offset: Vector = (0.0, 0.0, 0.0), breaking_stress: float = math.inf, slack: bool = False) -> Joint:
        """A spring for each particle of a patch of the surface, to a body or group by name, to a tool, or to points of
        the world at `offset`, m, from the particles. N/m^3, N s/m^3, Pa: per area."""
        rows, vector = self._rows(where), floats(offset, (3,), "an offset")
        options = sized("phymul_joint_options", slack=slack, stiffness=stiffness, damping=damping,
                         breaking=other_than_zero(breaking_stress, "breaking_stress"))
        body = to if isinstance(to, str) else None
        tool = 0 if to is None or body is not None else instance(to, Tool, "a partner")._number_in(self)
        return self._add(Joint, library.phymul_attach, rows.ctypes.data, len(rows), body, tool, vector.ctypes.data,
                         _ref(options))

    def hold_near(self, vertices: Any, triangles: Any, centre: Vector, radius: float, spacing: float) -> Joint:
        """Holds the part of a surface in a ball, in all directions, whatever particles lie there. The surface may be
        that which the body was made from; spacing, m: a third of the body's."""
        vertices, triangles = floats(vertices, (-1, 3), "vertices"), integers(triangles, 3, "triangles")
        middle = floats(centre, (3,), "a centre")
        return self._add(Joint, library.phymul_hold_near, vertices.ctypes.data, len(vertices), triangles.ctypes.data,
                         len(triangles), middle.ctypes.data, radius, spacing)

    def add_body_types(self) -> list[str]:
        """Adds what the components of a .pml file are by their bodyType: springs, held bodies, contacts. Returns a
        sentence for each."""
        return lines_of(library.phymul_add_body_types, self._pointer)

    def bind(self, points: Any, triangles: Any = ()) -> Skin:
        """Points [n][3], m at rest, that move with the body, such as the vertices of a finer surface; triangles for
        normals."""
        return Skin(self, floats(points, (-1, 3), "points"), integers(triangles, 3, "triangles"))

    def add_thread(self, thread: Thread, start: Vector, direction: Vector) -> ThreadHandle:
        """A free thread, straight from `start`, m, along a direction."""
        ends = [floats(value, (3,), "a start or direction") for value in (start, direction)]
        return self._add(ThreadHandle, library.phymul_thread_add, _ref(constants_of("phymul_thread", thread)),
                         *(end.ctypes.data for end in ends))

    def sew(self, thread: Thread, places: Any) -> ThreadHandle:
        """A thread through places [n][3] of the body, m at rest. Both tips are fixed."""
        places = floats(places, (-1, 3), "places")
        return self._add(ThreadHandle, library.phymul_thread_sew, _ref(constants_of("phymul_thread", thread)),
                         places.ctypes.data, len(places))

    def swage(self, thread: Thread, needle: Tool) -> ThreadHandle:
        """A thread at the tail of a needle, which sews it."""
        return self._add(ThreadHandle, library.phymul_thread_swage, _ref(constants_of("phymul_thread", thread)),
                         needle._number_in(self))

    def add_clip(self, clip: Clip, one: Anchor, other: Anchor) -> ThreadHandle:
        """Clips two walls together, each held at its anchor of particles. It closes during the next step or advance."""
        ends = [self._anchor(one), self._anchor(other)]
        return self._add(ThreadHandle, library.phymul_clip_add, _ref(constants_of("phymul_clip", clip)),
                         *(_ref(end[0]) for end in ends))

    def add_fluid(self: Own, name: str, triangles: Any, volume: float, fluid: Fluid = Fluid()) -> Own:
        """Fills a closed surface of triangles of particles, counter-clockwise seen from outside, as `body.triangles`.
        volume: m^3, that the fluid has without pressure."""
        rows = integers(triangles, 3, "triangles")
        struct, _kept = fluid._struct()
        library.phymul_volume_add(self._pointer, name, rows.ctypes.data, len(rows), volume, _ref(struct))
        return self

    def set_volume(self: Own, name: str, volume: float) -> Own:
        """m^3, of the fluid without pressure. constrain_volume() calls a volume "volume 3" if it is the third added."""
        library.phymul_volume_set(self._pointer, name, volume)
        return self

    def set_fluid(self: Own, name: str, fluid: Fluid) -> Own:
        """As much of it as there is; opens and closes openings."""
        struct, _kept = fluid._struct()
        library.phymul_volume_set_fluid(self._pointer, name, _ref(struct))
        return self

    def remove_volume(self: Own, name: str) -> Own:
        library.phymul_volume_remove(self._pointer, name)
        return self

    def fluid(self, name: str) -> FluidState:
        """After the last step."""
        volume, pressure = ctypes.c_double(), ctypes.c_double()
        library.phymul_volume_read(self._pointer, name, _ref(volume), _ref(pressure))
        return FluidState(volume.value, pressure.value)

    def tear(self: Own, toughness: float, radius: float = 0.0, material: Optional[Material] = None) -> Own:
        """Cells tear from now on where tissue is pulled too hard: of a material as Body.set_material returned it, or
        all. J/m^2; 0: nothing tears. radius: m; 0: two spacings. StepReport.torn counts them."""
        struct = _ref(material._struct) if material else None
        library.phymul_tear(self._pointer, struct, toughness, radius)
        return self
