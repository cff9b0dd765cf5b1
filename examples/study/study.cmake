# SPDX-License-Identifier: MIT
#
# phymul-study and its tests: docs/guide/studies.md.
add_library(phymul_study STATIC
  ${PROJECT_SOURCE_DIR}/bench/expression.cpp
  study/crew.cpp
  study/file.cpp
  study/fit.cpp
  study/journal.cpp
  study/measurement.cpp
  study/sampler.cpp
  study/scene.cpp
  study/tables.cpp)
target_include_directories(phymul_study PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_LIST_DIR}
                                               ${PROJECT_SOURCE_DIR}/bench)
target_link_libraries(phymul_study PUBLIC phymul phymul_run_body ZLIB::ZLIB
                                   PRIVATE muparser::muparser phymul_warnings phymul_sanitizers)
phymul_precompile_users(program phymul_study)
phymul_compile_together(phymul_study)

phymul_example(phymul-study study/phymul_study.cpp study/options.cpp study/progress.cpp study/ranks.cpp)
target_link_libraries(phymul-study PRIVATE phymul_study CLI11::CLI11)
if(phymul_has_mpi)
  target_link_libraries(phymul-study PRIVATE MPI::MPI_CXX)
  target_compile_definitions(phymul-study PRIVATE PHYMUL_HAS_MPI)
endif()

if(NOT PHYMUL_BUILD_TESTS)
  return()
endif()

include(${PROJECT_SOURCE_DIR}/tests/suites.cmake)
add_executable(phymul_study_test study/files_test.cpp study/study_test.cpp)
phymul_optimise_test(phymul_study_test)
phymul_precompile_users(test phymul_study_test)
target_link_libraries(phymul_study_test PRIVATE phymul_study GTest::gtest_main phymul_warnings phymul_sanitizers)
phymul_test_suites(phymul_study_test)

# Two processes of any MPI; Open MPI asks root, and a machine of one core, whether they mean it.
set(mpirun "")
if(phymul_has_mpi)
  set(mpirun ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} 2)
  set(mpi_environment OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
                      OMPI_MCA_hwloc_base_binding_policy=none OMPI_MCA_plm_rsh_agent=false)
endif()
set(tissue ${PROJECT_SOURCE_DIR}/tests/data/mesh/mixed_41.msh)
add_test(NAME example.phymul_study
         COMMAND ${CMAKE_COMMAND} -DSTUDY=$<TARGET_FILE:phymul-study> -DRUN=$<TARGET_FILE:phymul-run>
                 -DMESH=${tissue} "-DMPIRUN=${mpirun}" -DOUT=${CMAKE_CURRENT_BINARY_DIR}/phymul_study_out
                 -P ${CMAKE_CURRENT_LIST_DIR}/program_test.cmake)
add_test(NAME example.phymul_study_killed
         COMMAND sh ${CMAKE_CURRENT_LIST_DIR}/kill_test.sh $<TARGET_FILE:phymul-study>
                 ${CMAKE_CURRENT_BINARY_DIR}/phymul_study_out/killed.study
                 ${CMAKE_CURRENT_BINARY_DIR}/phymul_study_killed)
add_test(NAME example.phymul_study_silicone  # a measured body: docs/guide/studies.md
         COMMAND phymul-study ${PROJECT_SOURCE_DIR}/examples/studies/silicone_beam.study
                 --out ${CMAKE_CURRENT_BINARY_DIR}/silicone_out)
add_test(NAME example.phymul_study_stiffness  # of the body that gave the measured file, with 4000 and 12000 Pa
         COMMAND phymul-study ${PROJECT_SOURCE_DIR}/examples/studies/bean_stiffness.study
                 --out ${CMAKE_CURRENT_BINARY_DIR}/stiffness_out)
set_tests_properties(example.phymul_study_stiffness PROPERTIES PASS_REGULAR_EXPRESSION "tissue = (39|40).*tumour = 1[12]")
set_tests_properties(example.phymul_study_silicone PROPERTIES PASS_REGULAR_EXPRESSION "silicone = 2[.]7[01]")
set_tests_properties(example.phymul_study PROPERTIES FIXTURES_SETUP studies
                                                     ENVIRONMENT "${mpi_environment}"
                                                     SKIP_REGULAR_EXPRESSION "MPI NOT TESTED")
set_tests_properties(example.phymul_study_killed PROPERTIES FIXTURES_REQUIRED studies TIMEOUT 300)
if(phymul_has_mpi)
  add_test(NAME example.phymul_study_killed_mpi
           COMMAND sh ${CMAKE_CURRENT_LIST_DIR}/kill_test.sh $<TARGET_FILE:phymul-study>
                   ${CMAKE_CURRENT_BINARY_DIR}/phymul_study_out/killed.study
                   ${CMAKE_CURRENT_BINARY_DIR}/phymul_study_killed_mpi ${mpirun})
  set_tests_properties(example.phymul_study_killed_mpi PROPERTIES FIXTURES_REQUIRED studies TIMEOUT 300
                                                                  ENVIRONMENT "${mpi_environment}")
endif()
