# SPDX-License-Identifier: MIT
#
# The one-line faults that tests/faults.sh puts in. Input: rows "file line"; -v wanted=<number> -v seed=<number>. Output,
# in random order, one for each line: rows of file, line, what it is, the line with the fault, separated by tabs.

# Minimal standard generator of Park and Miller: the same numbers from every awk.
function below(end) {
  seed = seed * 16807 % 2147483647
  return seed % end
}

# The line with blanks where its texts and comments are.
function code_of(line,    out, k, c, quote) {
  for (k = 1; k <= length(line); ++k) {
    c = substr(line, k, 1)
    if (quote == "" && c == "/" && substr(line, k + 1, 1) ~ /[\/*]/) break
    if (quote != "" && c == "\\") { out = out " "; ++k }
    out = out (quote == "" && c !~ /["']/ ? c : " ")
    if (c == quote) quote = ""
    else if (quote == "" && (c == "\"" || c == "'" && substr(line, k - 1, 1) !~ /[0-9]/)) quote = c
  }
  return out
}

function add(start, size, into, what) {
  found[++count] = substr(text, 1, start - 1) into substr(text, start + size)
  name[count] = what
}

function swap(from, into,    at, rest) {
  for (at = index(code, from); at > 0; at = rest > 0 ? at + rest : 0) {
    add(at, length(from), into, from " becomes " into)
    rest = index(substr(code, at + 1), from)
  }
}

function change_constants(    at, start, literal) {
  for (at = 1; match(substr(code, at), /[0-9]+(\.[0-9]*)?([eE][-+]?[0-9]+)?/); at = start + length(literal)) {
    start = at + RSTART - 1
    literal = substr(code, start, RLENGTH)
    # Not parts of names, arguments of templates and hexadecimal numbers.
    if (substr(" " code, start, 1) ~ /[A-Za-z0-9_.<]/ || substr(code, start + length(literal), 1) ~ /[A-Zxa-df-z>]/) continue
    if (literal ~ /^[0-9]+$/) add(start, length(literal), literal + 1, literal " becomes " literal + 1)
    else add(start, length(literal), literal + 0 ? "(2 * " literal ")" : "1.0", literal (literal + 0 ? " doubled" : " becomes 1"))
  }
}

function negate_condition(    start, k, depth, c) {
  if (!match(code, /(^| )if \(/)) return
  start = RSTART + RLENGTH
  for (k = start; k <= length(code) && depth >= 0; ++k) {
    c = substr(code, k, 1)
    depth += (c == "(") - (c == ")")
  }
  if (depth < 0 && !index(substr(code, start, k - 1 - start), ";"))
    add(start, k - 1 - start, "!(" substr(text, start, k - 1 - start) ")", "condition negated")
}

function find_faults(before,    k, pair) {
  count = 0
  if (code ~ /^ *(#|using |template |class |struct |enum |namespace |public:|private:|\})|assert\(|reserve\(|operator[^ a-z]/) return
  for (k = 1; k <= words + signs; ++k) {
    split(pairs[k], pair, " ")
    swap(blank[k] pair[1] blank[k], blank[k] pair[2] blank[k])
    swap(blank[k] pair[2] blank[k], blank[k] pair[1] blank[k])
  }
  if (match(code, /[ (]![a-z(]/)) add(RSTART + 1, 1, "", "! dropped")
  if (match(code, /(return |\()-[a-z(]/)) add(RSTART + RLENGTH - 2, 1, "", "- dropped")
  if (match(code, /[A-Za-z0-9_)]\[[a-z_]+\]/)) add(RSTART + RLENGTH - 1, 1, " + 1]", "index off by one")
  change_constants()
  negate_condition()
  # Assignments, calls, jumps and whole ifs; not declarations.
  if (before ~ /([;{}:]|^) *$/ && code ~ /; *$/ &&
      code ~ /^ *([a-z_][^ (]* [-+*\/|&]?= |[a-z_][A-Za-z0-9_.:>-]*\(.*\);|if \(.*;|(\+\+|--)[a-z]|(return|continue|break);)/)
    add(1, length(text), ";", "statement deleted")
}

BEGIN {
  OFS = "\t"
  seed = (seed + 1) * 48271 % 2147483647
  words = split("std::min std::max,minCoeff maxCoeff,all_of any_of,true false", pairs, ",")
  signs = split("< <=,> >=,== !=,+ -,+= -=,* /,*= /=,&& ||", more, ",")
  for (k = 1; k <= signs; ++k) { pairs[words + k] = more[k]; blank[words + k] = " " }
}

{ places[NR] = $0 }

END {
  for (k = 1; k <= NR && wanted > 0; ++k) {  # Fisher and Yates
    other = k + below(NR - k + 1)
    split(places[other], part, " ")
    places[other] = places[k]
    for (line = before = text = ""; line < part[2] && (getline text < part[1]) > 0; ++line) { before = code; code = code_of(text) }
    close(part[1])
    find_faults(part[2] > 1 ? before : "")
    if (count == 0) continue
    one = 1 + below(count)
    print part[1], part[2], name[one], found[one]
    --wanted
  }
}
