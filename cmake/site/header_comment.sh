#!/bin/sh
# SPDX-License-Identifier: MIT
#
# A public header as doxygen wants it: the comment at its top becomes that of the file.
exec sed -e '1s|^// SPDX.*|/// @file|' -e '2,/^[^/]/s|^//\( \|$\)|///\1|' "$1"
