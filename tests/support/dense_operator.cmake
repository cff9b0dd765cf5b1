# SPDX-License-Identifier: MIT
#
# phymul_dense_operator: dense_operator.h, for tests and for bench/stability_atlas. Name it before phymul or
# phymul_inside: it serves programs that link either.
include_guard(GLOBAL)
add_library(phymul_dense_operator STATIC ${CMAKE_CURRENT_LIST_DIR}/dense_operator.cpp)
target_compile_features(phymul_dense_operator PUBLIC cxx_std_20)
target_include_directories(phymul_dense_operator PUBLIC $<TARGET_PROPERTY:phymul,INTERFACE_INCLUDE_DIRECTORIES>)
target_link_libraries(phymul_dense_operator PUBLIC Eigen3::Eigen PRIVATE phymul_warnings phymul_sanitizers)
phymul_optimise_test(phymul_dense_operator)
