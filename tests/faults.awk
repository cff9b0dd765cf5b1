# SPDX-License-Identifier: MIT
#
# The one-line faults that tests/faults.sh puts in. Input: rows "file line"; -v wanted=<number> -v seed=<number>. Output,
# in random order and at most one for each line: rows of file, line, what it is, and the line with the fault, separated
# by tabs.

# Minimal standard generator of Park and Miller: the same numbers from every awk.
function below(end) {
  seed = seed * 16807 % 2147483647
  return seed % end
}

# The line without what is no code, at the same columns: texts, characters and comments are blanks.
function code_of(line,    out, k, c, quote) {
  out = quote = ""
  for (k = 1; k <= length(line); ++k) {
    c = substr(line, k, 1)
    if (quote != "") {
      if (c == "\\") { out = out " "; ++k }
      else if (c == quote) quote = ""
      out = out " "
    } else if (c == "\"" || (c == "'" && substr(line, k - 1, 1) !~ /[0-9]/)) {
      quote = c
      out = out " "
    } else if (substr(line, k, 2) == "//" || substr(line, k, 2) == "/*") {
      break
    } else {
      out = out c
    }
  }
  return out
}

function add(start, size, into, what) {
  found[++count] = substr(text, 1, start - 1) into substr(text, start + size)
  name[count] = what
}

function swap(from, into,    at, next_at) {
  for (at = index(code, from); at > 0; at = next_at > 0 ? at + next_at : 0) {
    add(at, length(from), into, from " becomes " into)
    next_at = index(substr(code, at + 1), from)
  }
}

function exchange(a, b) {
  swap(a, b)
  swap(b, a)
}

function change_constants(    rest, at, literal, start, before) {
  for (at = 1; match(substr(code, at), /[0-9]+(\.[0-9]*)?([eE][-+]?[0-9]+)?/); at = start + length(literal)) {
    start = at + RSTART - 1
    literal = substr(code, start, RLENGTH)
    before = substr(code, start - 1, 1)
    rest = substr(code, start + length(literal), 1)
    # Not parts of names, arguments of templates and hexadecimal numbers.
    if (start > 1 && before ~ /[A-Za-z0-9_.<']/ || rest ~ /[A-Zxa-df-z>']/) continue
    if (literal ~ /^[0-9]+$/) add(start, length(literal), literal + 1, literal " becomes " literal + 1)
    else if (literal + 0 == 0) add(start, length(literal), "1.0", literal " becomes 1.0")
    else add(start, length(literal), "(2 * " literal ")", literal " is doubled")
  }
}

# The last but one character of the first match.
function drop_sign(pattern) {
  if (match(code, pattern)) add(RSTART + RLENGTH - 2, 1, "", substr(code, RSTART + RLENGTH - 2, 1) " dropped")
}

function shift_indices(    at, start) {
  for (at = 1; match(substr(code, at), /[A-Za-z0-9_)]\[[a-z_]+\]/); at = start + RLENGTH) {
    start = at + RSTART - 1
    add(start + RLENGTH - 1, 1, " + 1]", "index off by one")
  }
}

function negate_condition(    start, k, depth, c) {
  if (!match(code, /(^| )if \(/)) return
  start = RSTART + RLENGTH
  depth = 1
  for (k = start; k <= length(code) && depth > 0; ++k) {
    c = substr(code, k, 1)
    depth += c == "(" ? 1 : c == ")" ? -1 : 0
  }
  if (depth > 0 || index(substr(code, start, k - 1 - start), ";")) return
  add(start, k - 1 - start, "!(" substr(text, start, k - 1 - start) ")", "condition negated")
}

# Assignments, calls, jumps and whole ifs; not declarations.
function delete_statement(before) {
  if (before !~ /([;{}:]|^) *$/ || code !~ /; *$/) return
  if (code ~ /^ *[a-z_][^ (]* [-+*\/|&]?= / || code ~ /^ *[a-z_][A-Za-z0-9_.:>-]*\(.*\);/ || code ~ /^ *if \(.*;/ ||
      code ~ /^ *(\+\+|--)[a-z]/ || code ~ /^ *(return|continue|break);/)
    add(1, length(text), substr(text, 1, match(text, /[^ ]/) - 1) ";", "statement deleted")
}

function find_faults(before) {
  count = 0
  if (code ~ /^ *(#|using |template |class |struct |enum |namespace |public:|private:|static_assert|\})/) return
  if (code ~ /assert\(|reserve\(|operator[^ a-z]/) return
  exchange(" < ", " <= ")
  exchange(" > ", " >= ")
  exchange(" == ", " != ")
  exchange(" + ", " - ")
  exchange(" += ", " -= ")
  exchange(" * ", " / ")
  exchange(" *= ", " /= ")
  exchange(" && ", " || ")
  exchange("std::min", "std::max")
  exchange("minCoeff", "maxCoeff")
  exchange("all_of", "any_of")
  exchange("true", "false")
  drop_sign("[ (]![a-z(]")
  drop_sign("(return |[(])-[a-z(]")
  change_constants()
  shift_indices()
  negate_condition()
  delete_statement(before)
}

function load(file,    line) {
  lines = 0
  while ((getline line < file) > 0) source[++lines] = line
  close(file)
  loaded = file
}

BEGIN {
  seed = (seed + 1) * 48271 % 2147483647
  OFS = "\t"
}

{ places[NR] = $0 }

END {
  for (k = 0; k < 10; ++k) below(2)
  for (k = 1; k <= NR; ++k) {  # Fisher and Yates
    other = k + below(NR - k + 1)
    place = places[other]
    places[other] = places[k]
    split(place, part, " ")
    if (loaded != part[1]) load(part[1])
    text = source[part[2]]
    code = code_of(text)
    find_faults(code_of(part[2] > 1 ? source[part[2] - 1] : ""))
    if (count == 0) continue
    one = 1 + below(count)
    print part[1], part[2], name[one], found[one]
    if (--wanted == 0) exit
  }
}
