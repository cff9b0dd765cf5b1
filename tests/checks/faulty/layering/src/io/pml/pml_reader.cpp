// SPDX-License-Identifier: MIT
#include <pugixml.hpp>
#include <phymul/model.h>
