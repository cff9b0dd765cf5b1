# SPDX-License-Identifier: MIT
"""Threads, clips, and fluids in closed surfaces."""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass
from typing import Any, Optional, Sequence

import numpy as np

from ._library import Error, constants, floats, library, sized, structs
from .body import Vector
from .interaction import Anchor, Numbered, constants_of

_ref = ctypes.byref


@dataclass(frozen=True)
class Thread:
    """Constants of a thread. The defaults are those of a polypropylene monofilament, USP 3-0."""

    length: float = 0.3  # m; of a sewn thread: with both tails
    radius: float = 0.15e-3  # m
    young: float = 2e9  # Pa
    bending_stiffness: Optional[float] = None  # N m^2; None: of a solid round section. A sewn thread has none
    density: float = 920.0  # kg/m^3. A sewn thread has no mass
    segment: float = 3e-3  # m, largest distance of nodes of a free thread
    damping: float = 0.0  # 1/s
    friction: float = 0.1  # on what it lies on; of a passage: tensions differ by exp(friction * angle)
    channel_friction: float = 0.0  # N, further difference of tensions at a passage
    breaking_force: float = math.inf  # N
    passage_limit: float = math.inf  # N at which the tissue tears
    throw_holding: float = 1.0  # N, of each throw of a knot
    touches: bool = False  # a free thread lies on tools, tissue, itself and such threads


@dataclass(frozen=True)
class Clip:
    """Pinches two walls together and stays."""

    gap: float = 0.5e-3  # m between the walls, once it is closed
    holding: float = 1.0  # N with which it closes, and above which it opens
    opening: float = 0.01  # m: a clip that has opened by so much more than at first has come off


@dataclass(frozen=True)
class Knot:
    a: int  # rows of passages
    b: int
    broken: bool
    rest_length: float  # m
    tension: float  # N
    slip: float  # m of thread that went through


@dataclass(frozen=True)
class ThreadState:
    """A thread after the last step. Arrays are copies."""

    positions: np.ndarray  # [points][3] m: nodes; of a sewn thread: tips and passages, 0 before its first step
    rest_lengths: np.ndarray  # [points - 1] m
    tensions: np.ndarray  # [points - 1] N
    broken: np.ndarray  # [points - 1]
    rows: np.ndarray  # of the passages that the thread still goes through
    slides: np.ndarray  # [rows] 0: sticks; 1 or -1: slides toward the last or first tip
    knots: list[Knot]
    sewn: int  # passages that a needle has made
    torn: int  # passages at which the tissue gave way
    pulled_out: int  # passages that a tip has slipped through
    force_first: np.ndarray  # N, of the thread on what its tips are anchored to
    force_last: np.ndarray
    touch: Optional[np.ndarray]  # [points][3] N, that what it lies on pushes it with; None: it lies on nothing


@dataclass(frozen=True)
class Fluid:
    """What a closed surface holds. law: "incompressible", "gas" (p = outer_pressure (r^-exponent - 1) at the ratio r of
    volumes) or "curve" (pairs of r and p, Pa, linear between them)."""

    law: str = "incompressible"
    outer_pressure: float = 101325.0  # Pa
    exponent: float = 1.0
    curve: Sequence[tuple[float, float]] = ()
    conductance: float = 0.0  # m^3/(Pa s), of an opening; 0: closed
    outlet_pressure: float = 0.0  # Pa, behind it
    opens_into: Optional[str] = None  # name of another fluid that is behind it; None: it leads outside

    def _struct(self) -> tuple[Any, np.ndarray]:
        """And what it points to."""
        if self.law not in ("incompressible", "gas", "curve"):
            raise Error(f'expected a fluid that is "incompressible", a "gas" or a "curve", got "{self.law}"')
        points = floats(self.curve if len(self.curve) else np.zeros((0, 2)), (-1, 2), "points of a curve")
        for name in ("outer_pressure", "exponent", "conductance"):
            if getattr(self, name) < 0 or (getattr(self, name) == 0 and name != "conductance"):
                least = "0 or more" if name == "conductance" else "a number above 0"
                raise Error(f"Fluid.{name}: expected {least}, got {getattr(self, name)!r:.100}")
        return sized("phymul_fluid", law=constants[self.law.upper()], outer_pressure=self.outer_pressure,
                     exponent=self.exponent, curve=points.ctypes.data, curve_points=len(points),
                     conductance=self.conductance, outlet_pressure=self.outlet_pressure,
                     opens_into=self.opens_into), points


@dataclass(frozen=True)
class FluidState:
    volume: float  # m^3, that it has without pressure; changes where there is an opening
    pressure: float  # Pa


def _tip(tip: str) -> int:
    if tip not in ("first", "last"):
        raise Error(f'expected the tip "first" or "last", got {tip!r:.100}')
    return constants[tip.upper()]


def _copy(address: Optional[int], kind: Any, count: int) -> np.ndarray:
    return np.array((kind * count).from_address(address)) if count else np.zeros(0, kind)


class ThreadHandle(Numbered):
    """A thread or a clip of a simulation. Calls take effect in the next step. Tips are "first" and "last"; passages are
    numbered as they were sewn."""

    def hold(self, node: int, position: Vector) -> None:
        """A node of a free thread goes to a place, m, during the next step or advance, and stays."""
        place = floats(position, (3,), "a position")
        self._call(library.phymul_thread_hold, node, place.ctypes.data)

    def release(self, node: int) -> None:
        self._call(library.phymul_thread_release, node)

    def join(self, tip: str, anchor: Anchor) -> None:
        struct, _kept = self._simulation._anchor(anchor)
        self._call(library.phymul_thread_join, _tip(tip), _ref(struct))

    def pull(self, tip: str, force: Vector) -> None:
        """N; 0: lets go."""
        newtons = floats(force, (3,), "a force")
        self._call(library.phymul_thread_pull, _tip(tip), newtons.ctypes.data)

    def fix(self, tip: str) -> None:
        """The sewn thread does not slide through its first or last passage."""
        self._call(library.phymul_thread_fix, _tip(tip))

    def clamp(self, tip: str, holding: float, gap: Optional[float] = None) -> None:
        """As fix(), up to a force, N. The segment there is first drawn to a length, m."""
        if gap is not None and gap < 0:
            raise Error(f"a gap: expected 0 or more, or None, got {gap!r:.100}")
        self._call(library.phymul_thread_clamp, _tip(tip), holding, -1.0 if gap is None else gap)

    def tie(self, passage: int, other: int, throws: int = 3) -> None:
        """Ties two passages; the knot holds throws * Thread.throw_holding, N."""
        self._call(library.phymul_thread_tie, passage, other, throws)

    def loosen(self, passage: int, other: int) -> None:
        self._call(library.phymul_thread_loosen, passage, other)

    def remove(self) -> None:
        self._call(library.phymul_thread_remove)

    @property
    def state(self) -> ThreadState:
        now = sized("phymul_thread_state")
        self._call(library.phymul_thread_read, _ref(now))
        knots = [structs["phymul_knot"].from_address(now.knots + k * ctypes.sizeof(structs["phymul_knot"]))
                 for k in range(now.knot_count)]
        return ThreadState(
            positions=_copy(now.positions, ctypes.c_double, 3 * now.points).reshape(-1, 3),
            rest_lengths=_copy(now.rest_lengths, ctypes.c_double, now.segments),
            tensions=_copy(now.tensions, ctypes.c_double, now.segments),
            broken=_copy(now.broken, ctypes.c_int32, now.segments).astype(bool),
            rows=_copy(now.rows, ctypes.c_int32, now.passages),
            slides=_copy(now.slides, ctypes.c_int32, now.passages),
            knots=[Knot(k.a, k.b, bool(k.broken), k.rest_length, k.tension, k.slip) for k in knots],
            sewn=now.sewn, torn=now.torn, pulled_out=now.pulled_out,
            force_first=np.array(now.force_first), force_last=np.array(now.force_last),
            touch=_copy(now.touch, ctypes.c_double, 3 * now.points).reshape(-1, 3) if now.touch else None)
