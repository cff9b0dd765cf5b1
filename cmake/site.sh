#!/bin/sh
# SPDX-License-Identifier: MIT
#
# Builds the site: the pages of docs/ by mkdocs, the interface by doxygen. Fails on a warning and on a broken link.
#   sh cmake/site.sh     results in build/site; open build/site/index.html, or serve it:
#                        python3 -m http.server --directory build/site     (the search needs a server)
set -eu
cd "$(dirname "$0")/.."
sh cmake/install-packages.sh site
site=cmake/site
pages=build/site-pages

rm -rf "$pages" build/site
mkdir -p "$pages/api"
version=$(sed -n 's/^project(phymul VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
PHYMUL_VERSION=$version PHYMUL_API=$pages/api doxygen "$site/Doxyfile"
PYTHONDONTWRITEBYTECODE=1 python3 "$site/gather.py" . "$pages" "$site/mkdocs.yml"
mkdocs build --quiet --strict --config-file "$site/mkdocs.yml"
python3 "$site/check_links.py" build/site
