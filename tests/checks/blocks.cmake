# SPDX-License-Identifier: MIT
#
# Code blocks of Markdown pages; common to the checks that read them.

# The pages of the project: README.md and docs/.
function(find_pages result)
  file(GLOB_RECURSE pages "${ROOT}/docs/*.md")
  set(${result} "${ROOT}/README.md" ${pages} PARENT_SCOPE)
endfunction()

# Blocks of a page: <prefix>_count, and <prefix>_language_<n> and <prefix>_code_<n> from 1 on.
function(read_blocks page prefix)
  file(READ "${page}" text)
  string(PREPEND text "\n")
  set(count 0)
  string(FIND "${text}" "\n```" begin)
  while(NOT begin EQUAL -1)
    math(EXPR begin "${begin} + 4")
    string(SUBSTRING "${text}" ${begin} -1 text)
    string(FIND "${text}" "\n" line_end)
    string(FIND "${text}" "\n```" end)
    if(end EQUAL -1)
      message(FATAL_ERROR "${page}: a block does not end")
    endif()
    math(EXPR count "${count} + 1")
    string(SUBSTRING "${text}" 0 ${line_end} language)
    math(EXPR length "${end} - ${line_end}")
    string(SUBSTRING "${text}" ${line_end} ${length} code)
    set(${prefix}_language_${count} "${language}" PARENT_SCOPE)
    set(${prefix}_code_${count} "${code}\n" PARENT_SCOPE)
    math(EXPR end "${end} + 4")
    string(SUBSTRING "${text}" ${end} -1 text)
    string(FIND "${text}" "\n```" begin)
  endwhile()
  set(${prefix}_count ${count} PARENT_SCOPE)
endfunction()
