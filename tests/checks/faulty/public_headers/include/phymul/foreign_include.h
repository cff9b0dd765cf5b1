// SPDX-License-Identifier: MIT
#include <pugixml.hpp>
#include <math.h>
#include <Eigen/Core>
#include <vector>
