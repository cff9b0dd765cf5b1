# SPDX-License-Identifier: MIT
#
# Every package phymul uses, found here and nowhere else. What only tests, benches or examples need is looked for
# only where they are built.

# Stops with a sentence that says what is missing and how to get it.
function(phymul_missing sentence debian_package)
  message(FATAL_ERROR "${sentence}, which CMake did not find. On Debian or Ubuntu: apt-get install ${debian_package}. "
                      "Where it is installed elsewhere, add its prefix to CMAKE_PREFIX_PATH. ${ARGN}")
endfunction()

# The first one that CMake comes to, 3.4 or 5, which follows it: asked for 3.4, CMake would pass over a package manager's
# Eigen 5 and take an older one of the system. phymul_eigen: the series, which users must have too.
find_package(Eigen3 QUIET NO_MODULE)
if(NOT Eigen3_FOUND OR Eigen3_VERSION VERSION_LESS 3.4 OR Eigen3_VERSION VERSION_GREATER_EQUAL 6)
  phymul_missing("phymul needs Eigen 3.4 or 5" libeigen3-dev)
endif()
set(phymul_eigen 3.4)
if(Eigen3_VERSION VERSION_GREATER_EQUAL 5)
  set(phymul_eigen 5)
endif()

find_package(pugixml QUIET)
if(NOT pugixml_FOUND)
  phymul_missing("phymul needs pugixml" libpugixml-dev)
endif()

find_package(ZLIB QUIET)
if(NOT ZLIB_FOUND)
  phymul_missing("phymul needs zlib" zlib1g-dev)
endif()

find_package(Threads REQUIRED)

# phymul_has_assimp: are surfaces read from glTF?
set(phymul_has_assimp OFF)
if(PHYMUL_WITH_ASSIMP)
  find_package(assimp QUIET)
  if(TARGET assimp::assimp)
    set(phymul_has_assimp ON)
  elseif(PHYMUL_WITH_ASSIMP STREQUAL "AUTO")
    message(STATUS "phymul: read_surface reads no glTF, because CMake did not find Assimp; on Debian or Ubuntu: "
                   "apt-get install libassimp-dev")
  else()
    phymul_missing("Reading glTF (PHYMUL_WITH_ASSIMP=${PHYMUL_WITH_ASSIMP}) needs Assimp" libassimp-dev
                   "Without it: -DPHYMUL_WITH_ASSIMP=OFF.")
  endif()
endif()

# phymul_has_nifti, phymul_has_teem: are labelled images read from files? Looked for by file: the one package has no
# description for CMake, and that of the other asks for programs that another Debian package brings.
set(phymul_has_nifti OFF)
set(phymul_has_teem OFF)
if(PHYMUL_WITH_LABELS)
  find_path(phymul_nifti_headers nifti1_io.h PATH_SUFFIXES nifti)
  find_library(phymul_nifti_library niftiio)
  find_library(phymul_znz_library znz)
  find_path(phymul_teem_headers teem/nrrd.h)
  find_library(phymul_teem_library teem)
  mark_as_advanced(phymul_nifti_headers phymul_nifti_library phymul_znz_library phymul_teem_headers phymul_teem_library)
  if(phymul_nifti_headers AND phymul_nifti_library AND phymul_znz_library)
    set(phymul_has_nifti ON)
    set(phymul_nifti_libraries ${phymul_nifti_library} ${phymul_znz_library})
  endif()
  if(phymul_teem_headers AND phymul_teem_library)
    set(phymul_has_teem ON)
  endif()
  if(PHYMUL_WITH_LABELS STREQUAL "AUTO" AND NOT (phymul_has_nifti AND phymul_has_teem))
    message(STATUS "phymul: read_labels does not read all formats, because CMake did not find nifticlib or teem; on "
                   "Debian or Ubuntu: apt-get install libnifti-dev libteem-dev")
  elseif(NOT (phymul_has_nifti AND phymul_has_teem))
    phymul_missing("Reading labelled images (PHYMUL_WITH_LABELS=${PHYMUL_WITH_LABELS}) needs nifticlib and teem"
                   "libnifti-dev libteem-dev" "Without them: -DPHYMUL_WITH_LABELS=OFF.")
  endif()
endif()

if(PHYMUL_BUILD_TESTS)
  find_package(GTest QUIET)
  if(NOT GTest_FOUND)
    phymul_missing("The tests need GoogleTest" libgtest-dev "Without tests: -DPHYMUL_BUILD_TESTS=OFF.")
  endif()
endif()

if(PHYMUL_BUILD_BENCH)
  find_package(benchmark QUIET)
  if(NOT benchmark_FOUND)
    phymul_missing("The benches need Google Benchmark" libbenchmark-dev "Without benches: -DPHYMUL_BUILD_BENCH=OFF.")
  endif()
  find_package(muparser QUIET)
  if(NOT muparser_FOUND)
    phymul_missing("The benches need muParser" libmuparser-dev "Without benches: -DPHYMUL_BUILD_BENCH=OFF.")
  endif()
  # A peer in the charts, never needed: the double-precision Bullet.
  find_package(PkgConfig QUIET)
  if(PkgConfig_FOUND)
    pkg_check_modules(bullet QUIET IMPORTED_TARGET bullet-float64)
  endif()
endif()

if(PHYMUL_BUILD_EXAMPLES AND NOT EMSCRIPTEN)
  set(without "Without examples: -DPHYMUL_BUILD_EXAMPLES=OFF.")
  find_package(CLI11 QUIET)
  if(NOT CLI11_FOUND)
    phymul_missing("The examples need CLI11" libcli11-dev "${without}")
  endif()
  find_package(PkgConfig QUIET)
  if(NOT PkgConfig_FOUND)
    phymul_missing("The examples need pkg-config" pkg-config "${without}")
  endif()
  pkg_check_modules(cairo QUIET IMPORTED_TARGET cairo)
  if(NOT cairo_FOUND)
    phymul_missing("The examples need cairo" libcairo2-dev "${without}")
  endif()
endif()

# phymul-study, and nothing else: expressions in its files, and the processes of a cluster. phymul_has_mpi: is there MPI?
set(phymul_has_mpi OFF)
if(PHYMUL_BUILD_EXAMPLES)
  find_package(muparser QUIET)
  if(NOT muparser_FOUND)
    message(STATUS "phymul: no tool phymul-study, because CMake did not find muParser; on Debian or Ubuntu: "
                   "apt-get install libmuparser-dev")
  elseif(PHYMUL_WITH_MPI)
    set(MPI_CXX_SKIP_MPICXX ON)
    find_package(MPI QUIET COMPONENTS CXX)
    if(MPI_CXX_FOUND)
      set(phymul_has_mpi ON)
    elseif(PHYMUL_WITH_MPI STREQUAL "AUTO")
      message(STATUS "phymul: phymul-study works on one machine alone, because CMake did not find MPI; on Debian or "
                     "Ubuntu: apt-get install libopenmpi-dev openmpi-bin")
    else()
      phymul_missing("phymul-study on several machines (PHYMUL_WITH_MPI=${PHYMUL_WITH_MPI}) needs MPI"
                     "libopenmpi-dev openmpi-bin" "Without it: -DPHYMUL_WITH_MPI=OFF.")
    endif()
  endif()
endif()

# phymul_has_gl: is the GL part built?
set(phymul_has_gl OFF)
if(PHYMUL_WITH_GL AND EMSCRIPTEN)
  set(phymul_has_gl ON)  # WebGL 2 is part of every browser
elseif(PHYMUL_WITH_GL)
  # GLEW's GL is asked for by its new name, so that CMake does not warn of there being two.
  set(OpenGL_GL_PREFERENCE GLVND)
  find_package(OpenGL QUIET COMPONENTS EGL OPTIONAL_COMPONENTS GLX)
  find_package(GLEW 2.1 QUIET)
  if(TARGET OpenGL::EGL AND TARGET GLEW::GLEW)
    set(phymul_has_gl ON)
  elseif(PHYMUL_WITH_GL STREQUAL "AUTO")
    message(STATUS "phymul: no GL backend, because CMake did not find GLEW and EGL; on Debian or Ubuntu: "
                   "apt-get install libglew-dev libegl-dev")
  else()
    phymul_missing("The GL backend (PHYMUL_WITH_GL=${PHYMUL_WITH_GL}) needs GLEW and EGL" "libglew-dev libegl-dev"
                   "Without it: -DPHYMUL_WITH_GL=OFF.")
  endif()
endif()

# The window of phymul-view, and nothing else.
if(PHYMUL_BUILD_EXAMPLES AND phymul_has_gl AND NOT EMSCRIPTEN)
  find_package(glfw3 3.3 QUIET)
  if(NOT glfw3_FOUND)
    message(STATUS "phymul: no viewer phymul-view, because CMake did not find GLFW; on Debian or Ubuntu: "
                   "apt-get install libglfw3-dev")
  endif()
endif()

message(STATUS "phymul ${PROJECT_VERSION}: GL ${phymul_has_gl}, Assimp ${phymul_has_assimp}, NIfTI ${phymul_has_nifti}, "
               "NRRD ${phymul_has_teem}, MPI ${phymul_has_mpi}")
