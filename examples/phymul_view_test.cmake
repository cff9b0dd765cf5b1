# SPDX-License-Identifier: MIT
#
# Runs phymul-view (VIEW) by script on an X server of its own (XVFB), and looks at its last frames with CHECK.
if(NOT XVFB)
  if("$ENV{PHYMUL_REQUIRE_GL}" STREQUAL "1")
    message(FATAL_ERROR "PHYMUL_REQUIRE_GL=1, but there is no Xvfb; on Debian or Ubuntu: apt-get install xvfb")
  endif()
  message("NOT TESTED: there is no Xvfb; on Debian or Ubuntu: apt-get install xvfb")
  return()
endif()
file(REMOVE_RECURSE ${OUT})
file(MAKE_DIRECTORY ${OUT})

function(view name expected_code expected_text)
  execute_process(COMMAND sh ${ON_X_SERVER} ${XVFB} 800x600x24 ${VIEW} --hidden
                          --width 400 --height 320 --png ${OUT}/${name}.png ${ARGN}
                  RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE err TIMEOUT 200)
  if(NOT code EQUAL expected_code OR NOT "${out}${err}" MATCHES "${expected_text}")
    message(FATAL_ERROR "phymul-view ${ARGN}\nexpected exit code ${expected_code} and \"${expected_text}\", "
                        "got ${code} and:\n${out}${err}")
  endif()
  if(code EQUAL 0)
    execute_process(COMMAND ${CHECK} ${OUT}/${name}.png RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE out)
    if(NOT code EQUAL 0)
      message(FATAL_ERROR "phymul-view ${ARGN}: ${out}")
    endif()
  endif()
endfunction()

function(expect_same first second same)
  file(SHA256 ${OUT}/${first}.png a)
  file(SHA256 ${OUT}/${second}.png b)
  if(same AND NOT a STREQUAL b)
    message(FATAL_ERROR "${first}.png and ${second}.png differ")
  elseif(NOT same AND a STREQUAL b)
    message(FATAL_ERROR "${first}.png and ${second}.png are the same")
  endif()
endfunction()

view(rest 0 "reference .*drawn from a copy" tetrahedron --backend reference --frames 3)
view(gl 0 "gl .*drawn from the solver's own texture" tetrahedron --backend gl --frames 3)
# At rest both backends hold the same places, to the last bit.
expect_same(rest gl TRUE)

# A hand takes a particle of the upper end, and pulls.
foreach(backend IN ITEMS reference gl)
  view(held_${backend} 0 ${backend} cylinder --fix bottom --backend ${backend} --frames 12 --drag 200 78 200 78)
  view(pulled_${backend} 0 ${backend} cylinder --fix bottom --backend ${backend} --frames 12 --drag 200 78 260 60)
  expect_same(held_${backend} pulled_${backend} FALSE)
endforeach()

# The sign + scales the colours, and so does the key that it is on.
view(scaled 0 reference cylinder --fix bottom --backend reference --frames 12 --drag 200 78 260 60 --keys "+")
view(scaled_too 0 reference cylinder --fix bottom --backend reference --frames 12 --drag 200 78 260 60 --keys "=")
expect_same(scaled scaled_too TRUE)
expect_same(scaled pulled_reference FALSE)

# Every key, two of them changing the backend to and fro.
view(keys 0 "275 particles" ${BODY} ${LOADS} --backend reference --frames 24 --keys "selpaotc=-bnrb fselpao")
view(layers 0 "275 particles" ${BODY} --backend reference --frames 4 --keys "sel")
if(SURFACE)
  # The surface of the file, and then the body that fills it.
  set(organ ${SURFACE} --unit 0.001 --spacing 0.012 --frames 3)
  view(skin 0 "gl .*drawn from the solver's own texture" ${organ} --backend gl)
  view(skin_copied 0 "reference .*drawn from a copy" ${organ} --backend reference)
  expect_same(skin skin_copied TRUE)
  view(filled 0 "gl " ${organ} --backend gl --keys "k")
  expect_same(skin filled FALSE)
  view(none 1 "a surface is filled; give --spacing" ${SURFACE} --frames 1)

  # A scalpel goes through, and a hand draws away what nothing holds any more; or goes half way.
  set(held ${SURFACE} --unit 0.001 --spacing 0.012 --fix-near 0.05 0.02 0 0.03 --backend gl)
  string(REPEAT "." 29 wait)
  set(pull --drag 110 160 60 100)
  view(whole 0 "drawn.* [0-9.]+ s\n" ${held} --frames 30)
  view(cut 0 "cut, 2 pieces\n" ${held} --frames 30 --keys "x" --drag 200 20 200 300)
  view(opened 0 "cut, 2 pieces\n" ${held} --frames 60 --keys "x${wait}x" --drag 200 20 200 300 ${pull})
  view(slit 0 "cut, 1 piece\n" ${held} --frames 60 --keys "x${wait}x" --drag 200 20 200 180 ${pull})
  expect_same(whole cut FALSE)
  expect_same(cut opened FALSE)
  expect_same(opened slit FALSE)
  # Undone after a change of the backend, and by going back to the beginning.
  view(undone 0 "drawn.* [0-9.]+ s\n" ${held} --frames 30 --keys "x..............bz" --drag 200 20 200 300)
  view(reset 0 "drawn.* [0-9.]+ s\n" ${held} --frames 30 --keys "x..............r" --drag 200 20 200 300)
  expect_same(whole undone TRUE)
  expect_same(whole reset TRUE)
  # A file that has cuts is shown as what they leave.
  execute_process(COMMAND ${RUN} ${SURFACE} --unit 0.001 --spacing 0.012 --cut 0 0 0 1 0 0 --max-time 0.001
                          --frame-interval 0 --no-pictures --out ${OUT}/cut_file OUTPUT_QUIET ERROR_QUIET)
  view(of_file 0 "cut, 2 pieces\n" ${OUT}/cut_file/rest.pml --from-file --backend gl --frames 3)
  view(its_cells 0 "cut, 2 pieces\n" ${OUT}/cut_file/rest.pml --from-file --backend gl --frames 3 --keys "k")
  expect_same(of_file its_cells FALSE)
  view(not_cut 0 "only a body of tetrahedra with a material can be cut" block --frames 2 --keys "x")
endif()
# A body of walls: nothing for a scalpel.
set(wall "<physicalModel><atoms><structuralComponent>")
foreach(atom IN ITEMS "0' x='0' y='0" "1' x='50' y='0" "2' x='50' y='40" "3' x='0' y='40")
  string(APPEND wall "<atom><atomProperties index='${atom}' z='0' mass='0.001'/></atom>")
endforeach()
string(APPEND wall "</structuralComponent></atoms><exclusiveComponents><multiComponent><structuralComponent>")
foreach(third IN ITEMS 1 3)
  string(APPEND wall
         "<cell><cellProperties type='TRIANGLE' young='5e4' poisson='0.4' density='1000' thickness='0.002'/>"
         "<atomRef index='0'/><atomRef index='2'/><atomRef index='${third}'/></cell>")
endforeach()
file(WRITE ${OUT}/wall.pml "${wall}</structuralComponent></multiComponent></exclusiveComponents></physicalModel>")
view(wall 0 "only a body of tetrahedra with a material can be cut" ${OUT}/wall.pml --from-file --frames 2 --keys "x")
file(WRITE ${OUT}/no_unit.lml "<loads><load type='Translation'><appliedTo>0-24</appliedTo>"
     "<valueEvent date='0' value='0'/><direction x='1'/></load></loads>")
view(noted 0 "note: [^\n]*unit" ${BODY} ${OUT}/no_unit.lml --backend reference --frames 2)
string(REPEAT "long" 2000 long)
view(none 1 "phymul-view: .*name too long" ${long} --frames 1)
view(none 1 "--frames: .*-5" tetrahedron --frames -5)
view(none 1 "--png requires --frames" tetrahedron)
view(none 1 "no_such_body.*expected a file" no_such_body --frames 1)
view(none 1 "no_such_backend" tetrahedron --backend no_such_backend --frames 1)
