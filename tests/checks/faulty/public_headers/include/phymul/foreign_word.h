// SPDX-License-Identifier: MIT
#include <phymul/types.h>
// zlib and pugi::xml_node may be spoken of
using Name = GLuint ;
