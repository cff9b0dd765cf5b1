# SPDX-License-Identifier: MIT
#
# phymul_gl: the GL part, a module that the library loads at the first wish for it. So a machine without GLEW, EGL or GL
# still loads the library and what is linked with it. See src/solver/gl_module.h.

# The text of the shaders is part of the library. A changed one makes it anew.
file(GLOB_RECURSE shaders CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/glsl/*.glsl ${PROJECT_SOURCE_DIR}/glsl/*.vert
     ${PROJECT_SOURCE_DIR}/glsl/*.frag)
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/shaders/embedded_shaders.cpp
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${PROJECT_BINARY_DIR}/shaders/embedded_shaders.cpp -DROOT=${PROJECT_SOURCE_DIR}/glsl "-DFILES=${shaders}"
          -P ${PROJECT_SOURCE_DIR}/cmake/embed_shaders.cmake
  DEPENDS ${shaders} ${PROJECT_SOURCE_DIR}/cmake/embed_shaders.cmake
  COMMENT "Embedding shaders" VERBATIM)

file(GLOB_RECURSE gl_sources CONFIGURE_DEPENDS src/gl/*.cpp)
if(EMSCRIPTEN)
  # A page has no modules and no EGL: this part is linked, and src/gl/web asks the browser for contexts.
  list(FILTER gl_sources EXCLUDE REGEX "/context/(context_own|egl_display|gl_functions)\\.cpp$")
  list(FILTER gl_sources EXCLUDE REGEX "/gl/(compute/.*|objects/storage_buffer\\.cpp$)")
  target_sources(phymul PRIVATE ${gl_sources} ${PROJECT_BINARY_DIR}/shaders/embedded_shaders.cpp src/solver/gl_linked.cpp)
  target_compile_definitions(phymul PRIVATE PHYMUL_HAS_GL)
  target_link_options(phymul INTERFACE -sMIN_WEBGL_VERSION=2 -sMAX_WEBGL_VERSION=2)
  return()
endif()
list(FILTER gl_sources EXCLUDE REGEX "/gl/web/")

# The tests of the inside take the same objects.
add_library(phymul_gl_objects OBJECT ${gl_sources} ${PROJECT_BINARY_DIR}/shaders/embedded_shaders.cpp)
find_package(Threads REQUIRED)
target_include_directories(phymul_gl_objects PUBLIC src)
target_compile_options(phymul_gl_objects PRIVATE -ffp-contract=off)
phymul_precompile_library(phymul_gl_objects)
phymul_compile_together(phymul_gl_objects)
set_target_properties(phymul_gl_objects PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden
                                                   VISIBILITY_INLINES_HIDDEN ON)
target_link_libraries(phymul_gl_objects PUBLIC phymul_inside GLEW::GLEW OpenGL::EGL Threads::Threads ${CMAKE_DL_LIBS}
                                        PRIVATE phymul_warnings phymul_sanitizers)

add_library(phymul_gl MODULE)
# It carries what it needs of the core itself, and shows none of it: a shared library hides its inside.
target_link_options(phymul_gl PRIVATE LINKER:--exclude-libs,ALL LINKER:--no-undefined)
target_link_libraries(phymul_gl PRIVATE phymul_gl_objects phymul_sanitizers)
set_target_properties(phymul_gl PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/phymul
                                           INSTALL_RPATH "$ORIGIN/..")

target_sources(phymul PRIVATE src/solver/gl_module.cpp)
target_compile_definitions(phymul PRIVATE PHYMUL_HAS_GL PHYMUL_LIBDIR_NAME="${CMAKE_INSTALL_LIBDIR}"
                                          PHYMUL_LIBDIR="${CMAKE_INSTALL_FULL_LIBDIR}")
target_link_libraries(phymul PRIVATE ${CMAKE_DL_LIBS})
get_target_property(type phymul TYPE)
if(type STREQUAL "STATIC_LIBRARY")
  # A program with a static phymul stands anywhere: the dynamic loader is told where the module is, as CMake tells it
  # of shared libraries. libphymul_c.so finds it beside itself, and is copied into Python packages.
  set(elsewhere $<NOT:$<STREQUAL:$<TARGET_PROPERTY:NAME>,phymul_c>>)
  target_link_options(phymul INTERFACE
    $<BUILD_INTERFACE:$<${elsewhere}:LINKER:-rpath,${PROJECT_BINARY_DIR}/phymul>>
    $<INSTALL_INTERFACE:LINKER:-rpath,$<INSTALL_PREFIX>/${CMAKE_INSTALL_LIBDIR}/phymul>)
endif()
