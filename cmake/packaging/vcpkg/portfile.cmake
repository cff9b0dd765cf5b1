# SPDX-License-Identifier: MIT
#
# A port of vcpkg, for an overlay: docs/guide/packages.md. PHYMUL_REPOSITORY and PHYMUL_COMMIT, in the environment, name
# where the sources come from.
vcpkg_check_linkage(ONLY_STATIC_LIBRARY)
if("$ENV{PHYMUL_REPOSITORY}" STREQUAL "" OR "$ENV{PHYMUL_COMMIT}" STREQUAL "")
  message(FATAL_ERROR "phymul: PHYMUL_REPOSITORY and PHYMUL_COMMIT must be set: docs/guide/packages.md")
endif()
vcpkg_from_git(OUT_SOURCE_PATH SOURCE_PATH URL "$ENV{PHYMUL_REPOSITORY}" REF "$ENV{PHYMUL_COMMIT}")
vcpkg_check_features(OUT_FEATURE_OPTIONS options FEATURES gl PHYMUL_WITH_GL surfaces PHYMUL_WITH_ASSIMP)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS ${options} -DPHYMUL_WITH_LABELS=OFF -DPHYMUL_WITH_C=OFF -DPHYMUL_BUILD_TESTS=OFF -DPHYMUL_BUILD_BENCH=OFF
          -DPHYMUL_BUILD_EXAMPLES=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/phymul)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
