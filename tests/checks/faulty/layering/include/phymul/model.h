// SPDX-License-Identifier: MIT
#include <phymul/scene.h>
#include <phymul/topology.h>
