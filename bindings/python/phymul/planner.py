# SPDX-License-Identifier: MIT
"""From an error and a rate to the coarsest body that keeps them."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any, Callable, Optional, Sequence

from ._library import (Builder, Error, ErrorCode, Owner, constants, decoded, library, make, other_than_zero, sized,
                       structs, text_of)
from .simulation import Simulation


@dataclass(frozen=True)
class Candidate:
    """What plan() varies. Build at `spacing`, m, and pass `**candidate.options` to Simulation."""

    spacing: float
    backend: str
    step: float
    threads: int

    @property
    def options(self) -> dict[str, Any]:
        return {"backend": self.backend, "step": self.step, "threads": self.threads}


@dataclass(frozen=True)
class Trial:
    """A candidate that was tried. Figures that are not known are NaN."""

    candidate: Candidate
    mean_spacing: float  # m
    error: float
    tick: float  # s of wall time
    rest: float  # s of wall time
    particles: int
    keeps_error: bool
    keeps_time: bool


def _candidate(struct: Any) -> Candidate:
    return Candidate(struct.spacing, decoded(struct.backend), struct.step, struct.threads)


def _trial(struct: Any) -> Trial:
    return Trial(_candidate(struct.candidate), struct.mean_spacing, struct.error, struct.tick, struct.rest,
                 struct.particles, bool(struct.keeps_error), bool(struct.keeps_time))


class _Building:
    """Calls the builder for the library, and keeps what it throws."""

    def __init__(self, build: Callable[[Candidate], Simulation]) -> None:
        self.build = build
        self.thrown: Optional[BaseException] = None
        self.function = Builder(self.call)

    def call(self, _: Any, candidate: int, made: Any) -> int:
        try:
            built = self.build(_candidate(structs["phymul_candidate"].from_address(candidate)))
            if not isinstance(built, Simulation):
                raise TypeError(f"the builder must return a Simulation, got {built!r:.100}")
            handle = built._own
            if handle.was_viewed:
                raise ValueError("the builder must not read arrays of the simulation: it is handed over")
            made[0] = handle.pointer
            handle.pointer = None
            self.thrown = None
            return 0
        except BaseException as thrown:  # an exception cannot pass through C
            self.thrown = thrown
            # A name is unknown at every spacing; other Errors may be of this one.
            leaves_out = isinstance(thrown, Error) and thrown.code != ErrorCode.UNKNOWN_NAME
            return ErrorCode.INVALID_ARGUMENT if leaves_out else ErrorCode.INTERNAL

    def run(self, kind: str, function: Any, *arguments: Any) -> Any:
        """make(), and what the builder threw last where it fails."""
        self.thrown = None
        try:
            return make(kind, function, *arguments)
        except Error:
            if self.thrown is not None:
                raise self.thrown from None
            raise


class Plan(Owner):
    """The result of plan()."""

    def __init__(self, building: _Building, options: Any) -> None:
        self._building = building
        self._handle = building.run("plan", library.phymul_plan_create, building.function, None, ctypes.byref(options))

    def _choice(self, which: str) -> Optional[Trial]:
        trial, exists = structs["phymul_trial"](), ctypes.c_int32()
        library.phymul_plan_choice(self._pointer, constants[which], ctypes.byref(trial), ctypes.byref(exists))
        return _trial(trial) if exists.value else None

    @property
    def chosen(self) -> Optional[Trial]:
        """None if the wishes are not kept; the next two are then what can be had."""
        return self._choice("CHOSEN")

    @property
    def most_accurate(self) -> Optional[Trial]:
        return self._choice("MOST_ACCURATE")

    @property
    def cheapest(self) -> Optional[Trial]:
        return self._choice("CHEAPEST")

    @property
    def trials(self) -> list[Trial]:
        rows, count = ctypes.c_void_p(), ctypes.c_int32()
        library.phymul_plan_trials(self._pointer, ctypes.byref(rows), ctypes.byref(count))
        return [_trial(row) for row in (structs["phymul_trial"] * count.value).from_address(rows.value or 0)]

    @property
    def report(self) -> str:
        """For people: a table of the trials, the choice and the reason."""
        return text_of(library.phymul_plan_report, self._pointer)

    def make(self, which: str = "chosen") -> Simulation:
        """The simulation of "chosen", "most_accurate" or "cheapest", by the builder."""
        if which not in ("chosen", "most_accurate", "cheapest"):
            raise Error(f'expected "chosen", "most_accurate" or "cheapest", got "{which}"')
        return Simulation._of(self._building.run("simulation", library.phymul_plan_make, self._pointer,
                                                 constants[which.upper()]))


def plan(build: Callable[[Candidate], Simulation], *, max_error: float, rate: float = 0.0, rest_in: float = 0.0,
         head_room: float = 0.8, probe_time: float = 0.0, coarsest: float = 0.0, finest: float = 0.0,
         budget: float = 20.0, backends: Sequence[str] = ("cpu",), most_threads: int = 0) -> Plan:
    """`build` makes a new simulation of a candidate, with its scene; it must not read its arrays. max_error: share of
    the displacement; rate: Hz, rest_in: s, one of them; the rest is in docs/guide/planning.md."""
    return Plan(_Building(build), sized(
        "phymul_plan_options", max_error=max_error, rate=rate, rest_in=rest_in,
        head_room=other_than_zero(head_room, "head_room"), probe_time=probe_time, coarsest=coarsest, finest=finest,
        budget=other_than_zero(budget, "budget"), most_threads=most_threads, backends="\n".join(backends)))
