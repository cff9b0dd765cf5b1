# SPDX-License-Identifier: MIT
#
# Runs phymul-run (RUN) shortly on the sample of DATA and on the mesh MESH, and looks for its results in OUT.
file(REMOVE_RECURSE ${OUT})

function(run expected_code expected_text)
  execute_process(COMMAND ${RUN} ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT code EQUAL expected_code OR NOT "${out}${err}" MATCHES "${expected_text}")
    message(FATAL_ERROR "phymul-run ${ARGN}\nexpected exit code ${expected_code} and \"${expected_text}\", "
                        "got ${code} and:\n${out}${err}")
  endif()
endfunction()

function(expect_file name)
  if(NOT EXISTS ${OUT}/${name})
    message(FATAL_ERROR "phymul-run did not write ${name}")
  endif()
  file(SIZE ${OUT}/${name} size)
  if(size EQUAL 0)
    message(FATAL_ERROR "phymul-run wrote an empty ${name}")
  endif()
endfunction()

# Let go early and cut short: not at rest, but all there.
set(sample ${DATA}/cylinder_275.pml ${DATA}/cylinder_275_pull.lml)
run(3 "not at rest.*particles +275.*Pulled at 0.02 s.*Let go at 0.02 s.*Stopped at 0.04 s.*let go at 0.02" ${sample} --let-go 0.02 --max-time 0.04 --frame-interval 0.01 --out ${OUT})
foreach(name frames/body.pvd frames/body_000000.vtu frames/body_000004.vtu energies.csv pulled.png let_go.png rest.png rest.csv
             rest.pml)
  expect_file(${name})
endforeach()

# What it wrote, it reads: the deformed body is a body, and a frame is a mesh.
run(3 "particles +275" ${OUT}/rest.pml --max-time 0.001 --frame-interval 0 --no-pictures --out ${OUT}/again)
run(3 "particles +275" ${OUT}/frames/body_000004.vtu --max-time 0.001 --frame-interval 0 --no-pictures
    --gravity 0 0 -9.81 --out ${OUT}/frame)

# The file of another name, with a step that is longer than a tenth of the frames' interval.
configure_file(${DATA}/cylinder_275.pml ${OUT}/BODY.PML COPYONLY)
run(3 "particles +275" ${OUT}/BODY.PML --from-file --gravity 0 0 -9.81 --dt 3.1e-4 --max-time 0.02 --frame-interval 0.001
    --no-pictures --out ${OUT}/frames)
file(STRINGS ${OUT}/frames/frames/body.pvd frames REGEX "<DataSet ")
list(LENGTH frames frames)
if(NOT frames EQUAL 21)
  message(FATAL_ERROR "phymul-run --frame-interval: expected 21 frames, got ${frames}")
endif()

# Where the time went, by pass; and nothing on the way where nothing is wanted.
run(3 "pass +runs.*move +[1-9].*all, of the wall time" ${sample} --profile --backend cpu --max-time 0.02 --frame-interval 0
    --no-pictures --out ${OUT}/profile)
execute_process(COMMAND ${RUN} ${sample} --quiet --let-go 0.005 --max-time 0.01 --frame-interval 0 --no-pictures --out ${OUT}/quiet
                OUTPUT_QUIET ERROR_VARIABLE said)
if(NOT said STREQUAL "")
  message(FATAL_ERROR "phymul-run --quiet said on the way: ${said}")
endif()

# Long work says where it is also where the standard error is no terminal.
execute_process(COMMAND ${RUN} ${sample} --damping 0 --max-time 1e6 --frame-interval 0 --no-pictures --out ${OUT}/long
                TIMEOUT 5 OUTPUT_QUIET ERROR_VARIABLE said)
if(NOT said MATCHES "t = +[0-9.]+ s .* steps/s\n")
  message(FATAL_ERROR "phymul-run was silent for five seconds: ${said}")
endif()

# A small stiff body comes to rest.
run(0 "steps to rest after the last date" ${MESH} --unit 0.01 --fix "fixed side" --gravity 0 0 -9.81 --damping 60
    --frame-interval 0 --out ${OUT}/mesh)
# rest.pml is in the unit that is usual for such a file.
run(1 "the nearest is 0.98[0-9]+ m away" ${OUT}/mesh/rest.pml --fix-near 1 0 0 0.1 --out ${OUT}/none)
# What is moved from the beginning is there after a step.
run(3 "Pulled at [0-9e.-]+ s: the driven particles are 10 mm from" ${MESH} --unit 0.01 --fix "fixed side" --move tip=0,0,0.01
    --max-time 0.01 --frame-interval 0 --no-pictures --out ${OUT}/moved)

# Pictures name the material of the body, also where it is that of the file.
set(short --dt 1e-4 --max-time 0.001 --frame-interval 0)
run(3 "Stopped" ${MESH} --unit 0.01 --young 20e3 ${short} --out ${OUT}/stiff)
run(3 "Stopped" ${OUT}/stiff/rest.pml --from-file ${short} --out ${OUT}/stiff_file)
file(SHA256 ${OUT}/stiff/rest.png a)
file(SHA256 ${OUT}/stiff_file/rest.png b)
if(NOT a STREQUAL b)
  message(FATAL_ERROR "phymul-run --from-file: expected the picture of the same body, ${OUT}/stiff/rest.png")
endif()

# A value that never changes is there from the beginning on, too, and stays.
file(WRITE ${OUT}/aside.lml "<loads><load type='Translation'><appliedTo>250-274</appliedTo><valueEvent date='0' value='5'/>"
     "<direction x='1'/><unit>mm</unit></load></loads>")
run(3 "Pulled at [0-9e.-]+ s: the driven particles are 5 mm from[^:]*Stopped" ${DATA}/cylinder_275.pml ${OUT}/aside.lml
    --fix "Fixed Dof" --max-time 0.01 --frame-interval 0 --no-pictures --out ${OUT}/aside)
# A force that has ended acts no more.
file(WRITE ${OUT}/pushed.lml "<loads><load type='Force'><appliedTo>tip</appliedTo><valueEvent date='0' value='0.01'/>"
     "<valueEvent date='0.01' value='0'/><direction z='-1'/><unit>N</unit></load></loads>")
run(0 "under force.*At rest at [^\n]* mm from the rest shape\\.\n" ${MESH} ${OUT}/pushed.lml --unit 0.01 --fix "fixed side"
    --damping 60 --frame-interval 0 --no-pictures --out ${OUT}/pushed)
run(1 "--let-go: expected a number above 0, got 0" ${sample} --let-go 0 --out ${OUT}/none)

# What nothing holds moves away, whatever its damping.
run(3 "nothing holds the part of particle 0: it moves away" ${MESH} --unit 0.01 --gravity 0 0 -9.81
    --max-time 0.05 --frame-interval 0 --no-pictures --out ${OUT}/loose)

# A surface in millimetres is filled, held at a place, and comes to rest.
set(bean ${DATA}/bean.stl --unit 0.001 --gravity 0 0 -9.81 --frame-interval 0 --no-pictures)
run(0 "steps to rest.*filled with [0-9]+ particles" ${bean} --spacing 0.012 --fix-near 0 0 -0.03 0.02
    --fix-near 0.05 0.02 0 0.02 --out ${OUT}/bean)
set(plan ${DATA}/bean.stl --unit 0.001 --gravity 0 0 -9.81 --hold-near 0 0 -0.03 0.035 --plan)
run(0 "Chosen: .*bean.stl --unit 0.001 --gravity 0 0 -9.81 --hold-near 0 0 -0.03 0.035 --spacing 0.0[0-9]+ --backend cpu --threads [12]"
    ${plan} --max-error 90% --rate=10)
run(3 "Not kept" ${plan} --max-error 0.9 --rate 1e8)
run(1 "expected a share as 3% or 0.03, got 300%" ${plan} --max-error 300%)
run(1 "--plan requires --max-error" ${plan})
run(1 "--tear: a rest shape is found without tears; give --probe-time" ${plan} --max-error 90% --cut 0 0 0 1 0 0 --tear 3 0)
run(0 "steps to rest.*filled with [0-9]+ particles" ${bean} --spacing 0.016 --fine-near 0 0 0.03 0.005 0.008
    --fix-near 0 0 -0.03 0.02 --out ${OUT}/fine_bean)
run(0 "steps to rest" ${bean} --spacing 0.012 --hold-near 0 0 -0.03 0.02 --out ${OUT}/held_bean)
run(1 "--hold-near: .*no part of the surface" ${bean} --spacing 0.012 --hold-near 1 0 0 0.02 --out ${OUT}/none)
run(0 "steps to rest" ${bean} --spacing 0.012 --hold-near 0 0 -0.03 0.02 --cut 0 0 0 1 0 0 --cut-front 0 0 0.01 0 0 -1
    --out ${OUT}/cut_bean)
file(STRINGS ${OUT}/held_bean/rest.csv whole)
file(STRINGS ${OUT}/cut_bean/rest.csv cut)
list(LENGTH whole whole)
list(LENGTH cut cut)
if(NOT cut GREATER whole)
  message(FATAL_ERROR "phymul-run --cut: expected copies of particles besides ${whole} lines, got ${cut}")
endif()
# A force tears what the cut has left: 2,326 mm^2 of the file's section, counted by whole cells.
set(notched ${bean} --spacing 0.012 --fix-near 0.05 0.02 0 0.025 --group tip=-0.05,0.02,0,0.025 --cut 0 0 0 1 0 0
    --cut-front 0 0 0.01 0 0 -1 --out ${OUT}/torn_bean)
run(3 "Torn: [1-9][0-9]+ cells, 2[0-4][0-9][0-9] mm.2 of 2 pieces" ${notched} --force tip=-1,0,0 --tear 3 0 --max-time 0.5)
run(3 "Torn: 0 cells, 0 mm.2 of 1 piece" ${notched} --force tip=-1,0,0 --tear 30 0 --max-time 0.3)
run(0 "Torn: [1-9][0-9]+ cells, [0-9]+ mm.2 of 1 piece.*At rest" ${notched} --move tip=-0.006,0,0 --tear 3 0)
# What it wrote of a torn body, it reads without a word about particles that nothing would hold.
execute_process(COMMAND ${RUN} ${OUT}/torn_bean/rest.pml --from-file --max-time 0.001 --frame-interval 0 --no-pictures
                        --out ${OUT}/torn_again RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE said)
if(NOT code EQUAL 3 OR said MATCHES "particles have")
  message(FATAL_ERROR "expected to read a torn body, got ${code} and: ${said}")
endif()
# A cut is drawn as it is in a body that can tear.
set(cut ${DATA}/bean.stl --unit 0.001 --spacing 0.012 --cut 0 0 0 1 0 0 --dt 2e-4 --max-time 0.001 --frame-interval 0)
run(3 "Stopped" ${cut} --out ${OUT}/cut_picture)
run(3 "Stopped" ${cut} --tear 30 0 --out ${OUT}/tear_picture)
file(SHA256 ${OUT}/cut_picture/rest.png a)
file(SHA256 ${OUT}/tear_picture/rest.png b)
if(NOT a STREQUAL b)
  message(FATAL_ERROR "phymul-run --cut: expected the picture of --tear, ${OUT}/cut_picture/rest.png")
endif()
run(1 "--tear requires --cut" ${bean} --spacing 0.012 --tear 3 0 --out ${OUT}/none)
run(1 "expected a number of 0 or more, got -1" ${notched} --tear -1 0)
run(1 "--cut: the plane 1 passes no cell" ${bean} --spacing 0.012 --cut 1 0 0 1 0 0 --out ${OUT}/none)
run(1 "--cut: .*normal" ${bean} --spacing 0.012 --cut 0 0 0 0 0 0 --out ${OUT}/none)
run(1 "--cut: .*tetrahedr" ${sample} --cut 0 0 0 0 0 1 --out ${OUT}/none)
run(1 "--cut-front requires --cut" ${bean} --spacing 0.012 --cut-front 0 0 0 0 0 1 --out ${OUT}/none)
run(1 "at least an eighth of the spacing" ${bean} --spacing 0.016 --fine-near 0 0 0 0.01 0.001 --out ${OUT}/none)
run(1 "--fix-near: expected a finite place and a radius of 0 or more" ${bean} --spacing 0.012 --fix-near 0 0 0 -1 --out ${OUT}/none)
run(1 "the nearest is 0.9[0-9]+ m away" ${bean} --spacing 0.012 --fix-near 1 0 0 0.02 --out ${OUT}/none)
run(1 "bean.stl: a surface is filled; give --spacing" ${bean} --out ${OUT}/none)
run(1 "--from-file: a surface has no masses" ${bean} --spacing 0.016 --from-file --out ${OUT}/none)
# Two regions of an image, in millimetres, each with its material.
string(REPEAT "0 " 20 none)
string(REPEAT "1 " 8 soft)
string(REPEAT "2 " 8 stiff)
string(REPEAT "${none}\n" 20 empty_layer)
string(REPEAT "0 0 ${soft}${stiff}0 0\n" 16 rows)
set(image ${OUT}/two_regions.nrrd)
string(REPEAT "${none}\n${none}\n${rows}${none}\n${none}\n" 8 layers)
file(WRITE ${image} "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 20 20 12\nspace: RAS\n"
                    "space directions: (4,0,0) (0,4,0) (0,0,4)\nspace origin: (0,0,0)\nencoding: ascii\n\n"
                    "${empty_layer}${empty_layer}${layers}${empty_layer}${empty_layer}")
set(regions ${image} --gravity 0 0 -9.81 --frame-interval 0 --no-pictures)
if(TEEM)
  run(0 "steps to rest.*filled with [0-9]+ particles.*; \"label 1\": 6[0-9.]+ of 65.54 ml; \"label 2\": 6" ${regions}
      --spacing 0.012 --fix-near 0.038 0.038 0.006 0.03 --material "label 1=10000,0.3" --material "label 2=40e3,0.3"
      --out ${OUT}/regions)
  run(1 "the name of a group, got \"label 3\"" ${regions} --spacing 0.012 --material "label 3=1e4,0.3" --out ${OUT}/none)
  run(1 "a labelled image is filled; give --spacing" ${regions} --out ${OUT}/none)
  run(3 "filled with [0-9]+ particles.*; \"label 1\": 6[0-9.]+ of 65.54 ml; \"label 2\": 6" ${regions} --spacing 0.012
      --fine-near 0.038 0.038 0.006 0.01 0.006 --fix-near 0.038 0.038 0.006 0.03 --max-time 0.01 --out ${OUT}/fine_regions)
  run(1 "says its unit itself" ${regions} --unit 0.001 --spacing 0.012 --out ${OUT}/none)
endif()
run(1 "expected GROUP=YOUNG,POISSON, as in liver=4000,0.45, got label 1=1e4" ${regions} --spacing 0.012
    --material "label 1=1e4" --out ${OUT}/none)
run(1 "--fine-near: expected a surface or a labelled image to be filled, got .*mixed_41.msh" ${MESH} --spacing 0.01
    --fine-near 0 0 0 0.01 0.006 --out ${OUT}/none)
run(1 "mixed_41.msh is neither a surface nor" ${MESH} --spacing 0.01 --out ${OUT}/none)

run(1 "expected a surface or a labelled image, which can be filled at any spacing, got .*mixed_41.msh" ${MESH} --plan
    --max-error 3%)

run(1 "no_such_file.pml: this file does not exist" no_such_file.pml --out ${OUT})
run(1 "no_such_group" ${MESH} --fix no_such_group --out ${OUT}/none)
run(1 "expected averaged.barycentric.*got sideways" ${MESH} --from-file --reaction sideways --out ${OUT}/none)
run(1 "expected a number above 0, got -1" ${MESH} --max-time -1 --out ${OUT}/none)
run(1 "this folder cannot be made" ${MESH} --out ${OUT}/rest.csv)
file(MAKE_DIRECTORY ${OUT}/taken/energies.csv)
run(1 "taken/energies.csv: expected a file that can be written" ${MESH} --frame-interval 0 --out ${OUT}/taken)
run(1 "^phymul-run: --dt: unstable_step: dt = 1 s is above the stable step [^\n]*\n$" ${sample} --dt 1 --out ${OUT}/refused)
if(EXISTS ${OUT}/refused)
  message(FATAL_ERROR "phymul-run wrote results of a step that was refused")
endif()
run(3 "not at rest after" ${sample} --damping 0 --let-go 0.005 --max-time 0.02 --frame-interval 0 --no-pictures --out ${OUT}/undamped)
run(1 "no_such_backend" ${MESH} --backend no_such_backend --out ${OUT}/none)
file(WRITE ${OUT}/plane.vtk "# vtk DataFile Version 3.0\nplane\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
     "0 0 0 1 0 0 1 1 0 0 1 0\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n9\n")
run(1 "give --from-file" ${OUT}/plane.vtk --out ${OUT}/none)
