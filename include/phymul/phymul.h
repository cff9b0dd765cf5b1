// SPDX-License-Identifier: MIT
//
// All a user needs. Backend authors also include topology_textures.h; elasticity.h gives the forces by themselves.
#pragma once

#include <phymul/bodies.h>
#include <phymul/body.h>
#include <phymul/camera.h>
#include <phymul/check.h>
#include <phymul/display.h>
#include <phymul/distance_grid.h>
#include <phymul/elasticity.h>
#include <phymul/error.h>
#include <phymul/gl.h>
#include <phymul/joint.h>
#include <phymul/label_file.h>
#include <phymul/labels.h>
#include <phymul/lml.h>
#include <phymul/material_fit.h>
#include <phymul/mesh.h>
#include <phymul/model.h>
#include <phymul/monitor.h>
#include <phymul/needle.h>
#include <phymul/plan.h>
#include <phymul/pml.h>
#include <phymul/recording.h>
#include <phymul/scene.h>
#include <phymul/shapes.h>
#include <phymul/simulation.h>
#include <phymul/skin.h>
#include <phymul/solver.h>
#include <phymul/state.h>
#include <phymul/state_file.h>
#include <phymul/state_transfer.h>
#include <phymul/statics.h>
#include <phymul/step_limit.h>
#include <phymul/surface.h>
#include <phymul/surface_file.h>
#include <phymul/surface_patch.h>
#include <phymul/task_runner.h>
#include <phymul/thread.h>
#include <phymul/tool.h>
#include <phymul/topology.h>
#include <phymul/types.h>
#include <phymul/version.h>
#include <phymul/virtual_coupling.h>
#include <phymul/wall.h>
#include <phymul/writer.h>
