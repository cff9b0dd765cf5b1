# Builds the program given as $1.
set -e
flags=$(pkg-config --cflags --libs phymul)
${CXX:-c++} -std=c++20 "$(dirname "$0")/../main.cpp" -o "$1" $flags
