#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# Usage: run.sh CMAKE BUILD_DIR SOURCE_DIR CXX
set -eu
cmake=$1 build=$2 source=$3 compiler=$4
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset GRAFT_PLUGIN_PATH || true

fail() { echo "FAILED: $1" >&2; exit 1; }

"$cmake" --install "$build" --prefix "$work/first" >/dev/null
# A package must not know where it was installed.
mv "$work/first" "$work/moved"
prefix=$work/moved
if grep -rlF "$source" "$prefix/lib/cmake" "$prefix"/lib/*/cmake 2>/dev/null; then
  fail "the CMake package names the source tree"
fi

# What is installed are the entries that core/README.md lists, and what they include.
include=$prefix/include/graft
sed -n '/^Public headers/,/^A complete/p' "$source/core/README.md" |
  grep -o '`[a-z]*/[a-z0-9_]*\.h[p]*`' | tr -d '`' >"$work/entries"
[ "$(wc -l <"$work/entries")" -ge 10 ] || fail "core/README.md lists no public headers"
while read -r entry; do
  [ -f "$include/core/$entry" ] || fail "$entry is listed in core/README.md and not installed"
  echo "#include \"core/$entry\"" >"$work/alone.cpp"
  "$compiler" -std=c++17 -fsyntax-only -I "$include" -isystem /usr/include/eigen3 \
    "$work/alone.cpp" || fail "$entry does not compile alone"
  cat "$work/alone.cpp" >>"$work/all.cpp"
done <"$work/entries"
"$compiler" -std=c++17 -M -I "$include" -isystem /usr/include/eigen3 "$work/all.cpp" |
  tr ' \\' '\n\n' | grep "^$include/" | sort -u >"$work/reached"
find "$include" -type f | sort >"$work/installed"
diff "$work/reached" "$work/installed" || fail "installed headers are not those in use"

"$cmake" -S "$source/tests/install/consumer" -B "$work/build" -DCMAKE_PREFIX_PATH="$prefix" \
  -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release \
  -DTUTORIALS="$source/apps/tutorials" >"$work/configure.log" 2>&1 ||
  { cat "$work/configure.log"; fail "configure"; }
"$cmake" --build "$work/build" >"$work/build.log" 2>&1 || { cat "$work/build.log"; fail "build"; }

# The installed program with the new plugin: unknown before, closed form after.
graft=$prefix/bin/graft
graph=$source/tests/install/consumer/levels.g2o
set +e
"$graft" optimize "$graph" 2>"$work/err"
code=$?
set -e
[ $code -eq 3 ] || fail "a graph of unknown types ended with $code"
grep -q "unknown tag 'VERTEX_LEVEL'" "$work/err" || fail "the unknown tag was not named"

plugin=$work/build/libgraft_levels.so
"$graft" optimize "$graph" --plugin "$plugin" -o "$work/out.g2o" >"$work/summary"
# The optimum in closed form: levels 9/13, 41/13, 61/13, chi2 18/13 (levels.g2o).
awk '$1 == "VERTEX_LEVEL" { v[$2] = $3; n++ }
     function off(a, b) { d = a - b; return d < 0 ? -d : d }
     END { exit !(n == 3 && off(v[1], 9 / 13) < 1e-9 && off(v[2], 41 / 13) < 1e-9 &&
                  off(v[3], 61 / 13) < 1e-9) }' "$work/out.g2o" ||
  { cat "$work/out.g2o"; fail "not the optimum in closed form"; }
grep -q "^chi2 final *1.38461538" "$work/summary" || { cat "$work/summary"; fail "chi2"; }

# A plugin folder of the user's own makes it known by its tags.
mkdir "$work/plugins"
cp "$plugin" "$work/plugins"
GRAFT_PLUGIN_PATH=$work/plugins "$graft" check "$graph" >/dev/null || fail "GRAFT_PLUGIN_PATH"
"$graft" types LEVEL_SUM --plugin "$plugin" | grep -q "id... ||" || fail "types"

# The tutorial, as a program of its own: the error of 10 cm is spread evenly.
"$work/build/first_graph" >"$work/tutorial" || { cat "$work/tutorial"; fail "first_graph"; }
grep -q "^converged" "$work/tutorial" || { cat "$work/tutorial"; fail "first_graph"; }
sh "$source/tests/install/new_plugin.sh" "$cmake" "$prefix" "$compiler" "$work"
echo "install test passed"
