# SPDX-License-Identifier: MIT
#
# phymul_dense_operator: dense_operator.h, for tests and for bench/stability_atlas.
include_guard(GLOBAL)
add_library(phymul_dense_operator STATIC ${CMAKE_CURRENT_LIST_DIR}/dense_operator.cpp)
target_link_libraries(phymul_dense_operator PUBLIC phymul PRIVATE phymul_warnings phymul_sanitizers)
phymul_optimise_test(phymul_dense_operator)
