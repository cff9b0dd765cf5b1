# SPDX-License-Identifier: MIT
#
# One step of the consumer tests: cmake -DSTEP=... -P run.cmake, with the variables tests/consumer/CMakeLists.txt gives.
cmake_minimum_required(VERSION 3.25)

set(consumers ${CMAKE_CURRENT_LIST_DIR})
set(body ${SOURCE}/examples/data/cylinder_275.pml)
set(installed ${SCRATCH}/installed)
set(configure_flags -G ${GENERATOR} -DCMAKE_BUILD_TYPE=${CONFIG} -DCMAKE_CXX_COMPILER=${COMPILER}
                    -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
if(STEP MATCHES "_other_kind$")
  set(installed ${SCRATCH}/installed_other_kind)
endif()

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The program's output starts with the version it was linked with.
function(run_program program)
  execute_process(COMMAND ${program} ${body} COMMAND_ECHO STDOUT OUTPUT_VARIABLE output ECHO_OUTPUT_VARIABLE
                  COMMAND_ERROR_IS_FATAL ANY)
  if(NOT output MATCHES "^phymul [0-9.]+: 275 particles, 10 steps")
    message(FATAL_ERROR "unexpected output of ${program}")
  endif()
  # A GL that this machine lacks is no fault of how phymul was linked; a module that is not found is.
  if(WITH_GL AND NOT output MATCHES "\ngl: ")
    message(FATAL_ERROR "${program} knows no backend \"gl\"")
  elseif(WITH_GL AND "$ENV{PHYMUL_REQUIRE_GL}" STREQUAL "1" AND NOT output MATCHES "\ngl: 10 steps")
    message(FATAL_ERROR "${program} makes no solver of backend \"gl\", which PHYMUL_REQUIRE_GL demands")
  elseif(output MATCHES "the GL part of phymul could not be loaded")
    message(FATAL_ERROR "${program} does not find the GL module")
  endif()
endfunction()

if(STEP STREQUAL "install")
  file(REMOVE_RECURSE ${installed})
  run(${CMAKE_COMMAND} --install ${BINARY} --config ${CONFIG} --prefix ${installed})

elseif(STEP STREQUAL "install_other_kind")
  file(REMOVE_RECURSE ${installed})
  run(${CMAKE_COMMAND} --install ${SCRATCH}/subdirectory/phymul --config ${CONFIG} --prefix ${installed})

elseif(STEP MATCHES "^find_package")
  set(build ${SCRATCH}/${STEP})
  file(REMOVE_RECURSE ${build})
  run(${CMAKE_COMMAND} -S ${consumers}/find_package -B ${build} ${configure_flags} -DCMAKE_PREFIX_PATH=${installed})
  run(${CMAKE_COMMAND} --build ${build} --config ${CONFIG})
  run_program(${build}/app)

elseif(STEP STREQUAL "subdirectory")
  set(build ${SCRATCH}/${STEP})
  set(other_kind ON)
  if(SHARED)
    set(other_kind OFF)
  endif()
  # Without optimisation: how to link is asked here, and the whole library is built for it.
  string(TOUPPER ${CONFIG} config)
  run(${CMAKE_COMMAND} -S ${consumers}/subdirectory -B ${build} ${configure_flags} -DPHYMUL_SOURCE=${SOURCE}
      "-DCMAKE_CXX_FLAGS_${config}=-O0 -DNDEBUG" -DBUILD_SHARED_LIBS=${other_kind} -DPHYMUL_INSTALL=ON)
  run(${CMAKE_COMMAND} --build ${build} --config ${CONFIG})
  run_program(${build}/app)

elseif(STEP STREQUAL "fetch_content")
  # Of the last commit; built it would be what the step before builds.
  execute_process(COMMAND git -C ${SOURCE} rev-parse HEAD OUTPUT_VARIABLE commit RESULT_VARIABLE no_repository
                  OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(no_repository)
    message(STATUS "FETCHCONTENT NOT TESTED: ${SOURCE} is no repository of git")
    return()
  endif()
  set(build ${SCRATCH}/${STEP})
  file(REMOVE_RECURSE ${build})
  run(${CMAKE_COMMAND} -S ${consumers}/fetch_content -B ${build} ${configure_flags} -DPHYMUL_REPOSITORY=file://${SOURCE}
      -DPHYMUL_COMMIT=${commit})
  execute_process(COMMAND ${CMAKE_COMMAND} -DCMAKE_BUILD_TYPE= ${build} OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
  if(NOT GENERATOR MATCHES "Multi|Visual|Xcode" AND NOT output MATCHES "phymul: compiled without optimisation")
    message(FATAL_ERROR "a guest without a build type is not told that it is slow:\n${output}")
  endif()

elseif(STEP MATCHES "^pkg_config")
  file(MAKE_DIRECTORY ${SCRATCH}/${STEP})
  file(GLOB_RECURSE pc ${installed}/*/phymul.pc)
  cmake_path(GET pc PARENT_PATH pc_folder)
  cmake_path(GET pc_folder PARENT_PATH libraries)
  set(ENV{PKG_CONFIG_PATH} ${pc_folder})
  # Of the shared library alone: where the GL module is must be told by the .pc file, or be clear from where phymul is.
  set(ENV{LD_LIBRARY_PATH} ${libraries})
  set(ENV{CXX} ${COMPILER})
  run(sh ${consumers}/pkg_config/build.sh ${SCRATCH}/${STEP}/app)
  run_program(${SCRATCH}/${STEP}/app)

elseif(STEP STREQUAL "c")
  file(GLOB_RECURSE library ${installed}/*/libphymul_c.so)
  cmake_path(GET library PARENT_PATH libraries)
  run(${COMPILER} -x c -std=c99 ${SOURCE}/bindings/c/example.c -o ${SCRATCH}/c_app -I ${installed}/include
      -L ${libraries} -lphymul_c -Wl,-rpath,${libraries})
  run(${SCRATCH}/c_app)

else()
  message(FATAL_ERROR "unknown step \"${STEP}\"")
endif()
