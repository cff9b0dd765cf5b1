# SPDX-License-Identifier: MIT
"""phymul deforms soft tissue: bodies, tools, joints, threads, fluids, skins, rest shapes, the planner.

Guide: docs/guide/python.md."""

from ._library import Error, ErrorCode, lines_of as _lines_of, library as _c
from .body import (Body, Material, MaterialFit, body_from_arrays, fit_material, make_block, make_body, make_cylinder,
                   make_tetrahedral_block, make_wall, read_body, read_surface)
from .interaction import (Anchor, Blade, Box, Capsule, HalfSpace, Jaws, JawsReport, Joint, JointReport, Load, Needle,
                          NeedleState, Pose, Skin, Sphere, Tool, ToolForce)
from .planner import Candidate, Plan, Trial, plan
from .simulation import Energy, RestReport, Simulation, Snapshot, StepError, StepReport
from .threads import Clip, Fluid, FluidState, Knot, Thread, ThreadHandle, ThreadState

__version__: str = _c.phymul_version().decode()


def backends() -> "list[str]":
    """Names that Simulation(backend=) accepts in this build, without "auto"."""
    return _lines_of(_c.phymul_backends)


__all__ = [
    "Anchor", "Blade", "Body", "Box", "Candidate", "Capsule", "Clip", "Energy", "Error", "ErrorCode", "Fluid",
    "FluidState", "HalfSpace", "Jaws", "JawsReport", "Joint", "JointReport", "Knot", "Load", "Material",
    "MaterialFit", "Needle", "NeedleState", "Plan", "Pose", "RestReport", "Simulation", "Skin", "Snapshot",
    "Sphere", "StepError", "StepReport", "Thread", "ThreadHandle", "ThreadState", "Tool", "ToolForce", "Trial",
    "backends", "body_from_arrays", "fit_material", "make_block", "make_body", "make_cylinder",
    "make_tetrahedral_block", "make_wall", "plan", "read_body", "read_surface",
]
