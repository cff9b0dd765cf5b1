// SPDX-License-Identifier: MIT
#include <pugixml.hpp>
