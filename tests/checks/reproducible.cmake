# SPDX-License-Identifier: MIT
#
# Two builds of the library in two folders have the same bytes, object by object and as a whole. Needs ROOT, SCRATCH,
# COMPILER and GENERATOR. By hand, an hour of one core:
#   cmake -DROOT=$PWD -DSCRATCH=build/reproducible -DCOMPILER=g++ -DGENERATOR=Ninja -P tests/checks/reproducible.cmake
cmake_minimum_required(VERSION 3.25)
cmake_path(ABSOLUTE_PATH SCRATCH NORMALIZE)
file(REMOVE_RECURSE ${SCRATCH})
cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)

# Their names differ in length, which the lengths of strings in the objects would show.
foreach(place one another/place)
  set(source ${SCRATCH}/${place}/phymul)
  set(build ${SCRATCH}/${place}/build)
  file(COPY ${ROOT}/CMakeLists.txt ${ROOT}/cmake ${ROOT}/include ${ROOT}/src ${ROOT}/glsl DESTINATION ${source})
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S ${source} -B ${build} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
            -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON -DPHYMUL_WITH_GL=OFF -DPHYMUL_WITH_C=OFF
            -DPHYMUL_BUILD_TESTS=OFF -DPHYMUL_BUILD_BENCH=OFF -DPHYMUL_BUILD_EXAMPLES=OFF -DPHYMUL_INSTALL=OFF
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${CMAKE_COMMAND} --build ${build} --target phymul --parallel ${cores}
                  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  file(GLOB_RECURSE made_${place} RELATIVE ${build} ${build}/*.o ${build}/libphymul.so.*)
  list(LENGTH made_${place} count)
  if(count LESS 20)
    message(FATAL_ERROR "expected the objects of a library in ${build}, got ${count} files")
  endif()
endforeach()

if(NOT made_one STREQUAL "${made_another/place}")
  message(FATAL_ERROR "the two builds made files of other names:\n${made_one}\n${made_another/place}")
endif()
set(differ "")
foreach(file IN LISTS made_one)
  file(SHA256 ${SCRATCH}/one/build/${file} first)
  file(SHA256 ${SCRATCH}/another/place/build/${file} second)
  if(NOT first STREQUAL second)
    string(APPEND differ "\n  ${file}")
  endif()
endforeach()
if(differ)
  message(FATAL_ERROR "the two builds differ in:${differ}")
endif()
message(STATUS "${count} files are the same in two builds")
