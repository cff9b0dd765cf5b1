# SPDX-License-Identifier: MIT
#
# phymul_warnings: linked PRIVATE to our own targets, so that no flag reaches a project that uses phymul.
add_library(phymul_warnings INTERFACE)
target_compile_options(phymul_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                                 $<$<BOOL:${PHYMUL_WARNINGS_AS_ERRORS}>:-Werror>)
