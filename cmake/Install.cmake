# SPDX-License-Identifier: MIT
#
# What `cmake --install` puts where, for find_package(phymul) and for pkg-config. Components are packages of Debian
# (Packages.cmake): runtime, gl, dev, tools.
include(CMakePackageConfigHelpers)

phymul_install_library(phymul)
if(phymul_has_gl)
  install(TARGETS phymul_gl LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/phymul COMPONENT gl)
endif()
install(DIRECTORY include/phymul ${PROJECT_BINARY_DIR}/include/phymul DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        COMPONENT dev FILES_MATCHING PATTERN "*.h")

# A static phymul leaves it to the program to link what phymul uses inside; a shared one has it linked already.
get_target_property(type phymul TYPE)
if(type STREQUAL "STATIC_LIBRARY")
  set(PHYMUL_IS_STATIC ON)
  set(PHYMUL_PC_LIBS "")
  set(PHYMUL_PC_PUBLIC "eigen3, pugixml, zlib")
  if(phymul_has_assimp)
    string(APPEND PHYMUL_PC_PUBLIC ", assimp")
  endif()
  if(phymul_has_nifti)
    string(APPEND PHYMUL_PC_LIBS " -lniftiio -lznz")
  endif()
  if(phymul_has_teem)
    string(APPEND PHYMUL_PC_LIBS " -lteem")
  endif()
  if(phymul_has_gl)
    # The GL module's folder, for the dynamic loader: a program with a static phymul stands anywhere. pkg-config puts
    # in where the tree is when the program is linked.
    string(APPEND PHYMUL_PC_LIBS " -Wl,-rpath,\${libdir}/phymul")
    if(CMAKE_DL_LIBS)
      string(APPEND PHYMUL_PC_LIBS " -l${CMAKE_DL_LIBS}")
    endif()
  endif()
else()
  set(PHYMUL_IS_STATIC OFF)
  set(PHYMUL_PC_PUBLIC "eigen3")
endif()

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/phymul)
install(EXPORT phymulTargets NAMESPACE phymul:: DESTINATION ${config_dir} COMPONENT dev)
configure_package_config_file(cmake/phymulConfig.cmake.in ${PROJECT_BINARY_DIR}/phymulConfig.cmake
                              INSTALL_DESTINATION ${config_dir} NO_SET_AND_CHECK_MACRO)
# Before 1.0 every minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/phymulConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/phymulConfig.cmake ${PROJECT_BINARY_DIR}/phymulConfigVersion.cmake
        DESTINATION ${config_dir} COMPONENT dev)

# Relative to the file's own folder: the installed tree can be moved.
file(RELATIVE_PATH PHYMUL_PC_PREFIX "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig" "${CMAKE_INSTALL_PREFIX}")
configure_file(cmake/phymul.pc.in ${PROJECT_BINARY_DIR}/phymul.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/phymul.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
