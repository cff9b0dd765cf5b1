# SPDX-License-Identifier: MIT
#
# phymul_gl: the GL part, a module that the library loads at the first wish for it. So a machine without GLEW, EGL or GL
# still loads the library and what is linked with it. See src/gl_module.h.

# The text of the shaders is part of the library. A changed one makes it anew.
set(shaders
  attractor_pass.glsl
  attractor_pull.glsl
  attractor_pull_enumerated.glsl
  bases_pass.glsl
  cells_pass.glsl
  closest_point.glsl
  contact_box_pass.glsl
  contact_grid_kernel.glsl
  contact_group.glsl
  contact_law.glsl
  contact_lists.glsl
  contact_nearest.glsl
  contact_next_pass.glsl
  contact_order_kernel.glsl
  contact_part_kernel.glsl
  contact_part_pass.glsl
  contact_phase_pass.glsl
  contact_press_kernel.glsl
  contact_queue_kernel.glsl
  contact_range.glsl
  contact_report_pass.glsl
  contact_search_kernel.glsl
  contact_search_pass.glsl
  contact_speed_pass.glsl
  contact_start_pass.glsl
  contact_surface_pass.glsl
  contact_surfaces.glsl
  contact_sweeps.glsl
  contact_tables.glsl
  contact_tool.glsl
  contact_tree.glsl
  cover_target.glsl
  delta_base.glsl
  delta_cell.glsl
  delta_height.glsl
  delta_spring.glsl
  delta_volume.glsl
  dialect_compute.glsl
  dialect_fragment.glsl
  display_ball.frag
  display_ball.vert
  display_body.glsl
  display_colour.glsl
  display_contour.vert
  display_line.frag
  display_line.glsl
  display_pair.vert
  display_surface.frag
  display_surface.vert
  distance_to_shape.glsl
  energy_pass.glsl
  force_of.glsl
  force_pass.glsl
  free_kernel.glsl
  free_pass.glsl
  free_step.glsl
  integrate_displacement.glsl
  kept_along_pass.glsl
  kept_facet.glsl
  kept_root_pass.glsl
  kept_step_kernel.glsl
  kept_step_pass.glsl
  kept_sums_kernel.glsl
  kept_sums_pass.glsl
  kept_tables.glsl
  lone_group.glsl
  measure_step.glsl
  momentum_pass.glsl
  needle_aim_pass.glsl
  needle_append_pass.glsl
  needle_around_pass.glsl
  needle_begin_pass.glsl
  needle_bend.glsl
  needle_bent.glsl
  needle_coupling.glsl
  needle_coupling_pass.glsl
  needle_end_pass.glsl
  needle_facets_pass.glsl
  needle_follow.glsl
  needle_follow_kernel.glsl
  needle_force_kernel.glsl
  needle_give_pass.glsl
  needle_held.glsl
  needle_held_rows.glsl
  needle_hold_pass.glsl
  needle_invert_pass.glsl
  needle_limits.glsl
  needle_marks_pass.glsl
  needle_means_pass.glsl
  needle_motion.glsl
  needle_node.glsl
  needle_nodes.glsl
  needle_pairs.glsl
  needle_panel_pass.glsl
  needle_parts_pass.glsl
  needle_search.glsl
  needle_select_pass.glsl
  needle_settle.glsl
  needle_settle_pass.glsl
  needle_shaft.glsl
  needle_state.glsl
  needle_stiffness_pass.glsl
  needle_surface.glsl
  needle_sweeps.glsl
  needle_tables.glsl
  needle_total.glsl
  needle_turn_parts_pass.glsl
  needle_turning.glsl
  needle_twist_pass.glsl
  needle_weights.glsl
  needle_weights_of.glsl
  needle_weights_pass.glsl
  net_force.glsl
  press_kernel.glsl
  press_pass.glsl
  pushed_tables.glsl
  reaction_pass.glsl
  report_events.glsl
  report_kernel.glsl
  report_pass.glsl
  show_kernel.glsl
  shown_attractor_pass.glsl
  step_kernel.glsl
  step_pass.glsl
  store_kept_step.glsl
  store_kept_sums.glsl
  store_step.glsl
  store_terms.glsl
  sum_kernel.glsl
  sum_pass.glsl
  tables.glsl
  tell_tools.glsl
  terms_kernel.glsl
  terms_of.glsl
  tool_sums_kernel.glsl
  tool_sums_pass.glsl
  tool_tables.glsl
  tools_pass.glsl
  touch_tools.glsl
  two_floats.glsl
  vector3.glsl
  volume_root.glsl
  volumes_pass.glsl
  wait_for_all.glsl
  workgroup_kernel.glsl)
list(TRANSFORM shaders PREPEND ${PROJECT_SOURCE_DIR}/glsl/)
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/shaders/embedded_shaders.cpp
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${PROJECT_BINARY_DIR}/shaders/embedded_shaders.cpp "-DFILES=${shaders}"
          -P ${PROJECT_SOURCE_DIR}/cmake/embed_shaders.cmake
  DEPENDS ${shaders} ${PROJECT_SOURCE_DIR}/cmake/embed_shaders.cmake
  COMMENT "Embedding shaders" VERBATIM)

# The tests of the inside take the same objects.
add_library(phymul_gl_objects OBJECT
  src/gl/body_drawing.cpp
  src/gl/body_kind.cpp
  src/gl/compute_contacts.cpp
  src/gl/compute_device.cpp
  src/gl/compute_loads.cpp
  src/gl/compute_needles.cpp
  src/gl/compute_passes.cpp
  src/gl/compute_report.cpp
  src/gl/compute_state.cpp
  src/gl/compute_sums.cpp
  src/gl/compute_tables.cpp
  src/gl/compute_tools.cpp
  src/gl/compute_volumes.cpp
  src/gl/contact_passes.cpp
  src/gl/context.cpp
  src/gl/context_current.cpp
  src/gl/context_debug.cpp
  src/gl/context_info.cpp
  src/gl/context_own.cpp
  src/gl/context_self_test.cpp
  src/gl/context_worker.cpp
  src/gl/device.cpp
  src/gl/device_batches.cpp
  src/gl/device_solver.cpp
  src/gl/display.cpp
  src/gl/drawing.cpp
  src/gl/egl_context.cpp
  src/gl/egl_display.cpp
  src/gl/fragment_contact_passes.cpp
  src/gl/fragment_contacts.cpp
  src/gl/fragment_device.cpp
  src/gl/fragment_loads.cpp
  src/gl/fragment_needle_passes.cpp
  src/gl/fragment_needles.cpp
  src/gl/fragment_passes.cpp
  src/gl/fragment_pushed.cpp
  src/gl/fragment_report.cpp
  src/gl/fragment_state.cpp
  src/gl/fragment_sums.cpp
  src/gl/fragment_tables.cpp
  src/gl/fragment_tools.cpp
  src/gl/fragment_volumes.cpp
  src/gl/step_traffic.cpp
  src/gl/framebuffer.cpp
  src/gl/gl_functions.cpp
  src/gl/guard_egl.cpp
  src/gl/guard_state.cpp
  src/gl/kernel.cpp
  src/gl/load_table.cpp
  src/gl/loop_turns.cpp
  src/gl/module.cpp
  src/gl/needle_passes.cpp
  src/gl/needle_textures.cpp
  src/gl/options.cpp
  src/gl/pass.cpp
  src/gl/pass_timer.cpp
  src/gl/picture_target.cpp
  src/gl/program.cpp
  src/gl/report_copy.cpp
  src/gl/shader_source.cpp
  src/gl/state_copies.cpp
  src/gl/storage_buffer.cpp
  src/gl/texture.cpp
  ${PROJECT_BINARY_DIR}/shaders/embedded_shaders.cpp)
find_package(Threads REQUIRED)
target_include_directories(phymul_gl_objects PUBLIC src)
target_compile_options(phymul_gl_objects PRIVATE -ffp-contract=off)
set_target_properties(phymul_gl_objects PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden
                                                   VISIBILITY_INLINES_HIDDEN ON)
target_link_libraries(phymul_gl_objects PUBLIC phymul GLEW::GLEW OpenGL::EGL Threads::Threads ${CMAKE_DL_LIBS}
                                        PRIVATE phymul_warnings phymul_sanitizers)

add_library(phymul_gl MODULE)
# Beside a static library it carries what it needs of the core itself, and shows none of it.
target_link_options(phymul_gl PRIVATE LINKER:--exclude-libs,ALL LINKER:--no-undefined)
target_link_libraries(phymul_gl PRIVATE phymul_gl_objects phymul_sanitizers)
set_target_properties(phymul_gl PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/phymul
                                           INSTALL_RPATH "$ORIGIN/..")

target_sources(phymul PRIVATE src/gl_module.cpp)
target_compile_definitions(phymul PRIVATE PHYMUL_HAS_GL PHYMUL_LIBDIR_NAME="${CMAKE_INSTALL_LIBDIR}"
                                          PHYMUL_LIBDIR="${CMAKE_INSTALL_FULL_LIBDIR}")
target_link_libraries(phymul PRIVATE ${CMAKE_DL_LIBS})
get_target_property(type phymul TYPE)
if(type STREQUAL "STATIC_LIBRARY")
  # A program with a static phymul stands anywhere: the dynamic loader is told where the module is, as CMake tells it
  # of shared libraries.
  target_link_options(phymul INTERFACE
    $<BUILD_INTERFACE:LINKER:-rpath,${PROJECT_BINARY_DIR}/phymul>
    $<INSTALL_INTERFACE:LINKER:-rpath,$<INSTALL_PREFIX>/${CMAKE_INSTALL_LIBDIR}/phymul>)
endif()
