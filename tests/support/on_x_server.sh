#!/bin/sh
# SPDX-License-Identifier: MIT
#
# usage: on_x_server.sh XVFB SCREEN COMMAND...
# Runs COMMAND on an X server of its own: XVFB is the program Xvfb, SCREEN its size and depth, as in 64x64x24. Exits with
# the code of COMMAND. The server looks for a free display itself, so that any number of these can run at once.
set -u
xvfb=$1
screen=$2
shift 2

dir=$(mktemp -d) || exit 1
mkfifo "$dir/display" || exit 1
"$xvfb" -displayfd 3 -screen 0 "$screen" -nolisten tcp -noreset 3>"$dir/display" >"$dir/log" 2>&1 &
server=$!
end() {
  kill "$server" 2>/dev/null
  wait "$server" 2>/dev/null
  rm -rf "$dir"
}
trap end EXIT
trap 'exit 1' HUP INT TERM

# The server writes the number once it can be connected to; one that ends before closes the pipe.
if ! read -r display <"$dir/display"; then
  echo "on_x_server.sh: $xvfb did not start:" >&2
  cat "$dir/log" >&2
  exit 1
fi
DISPLAY=:$display "$@"
