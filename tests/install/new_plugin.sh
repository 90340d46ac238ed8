#!/bin/sh
# SPDX-License-Identifier: BSD-3-Clause
# A user's way from an empty folder to a solved graph with an edge of one's own,
# against the installed package: four commands and fifteen lines.
# Usage: new_plugin.sh CMAKE PREFIX CXX WORK
set -eu
cmake=$1 prefix=$2 compiler=$3 work=$4
PATH=$prefix/bin:$PATH
CMAKE_PREFIX_PATH=$prefix
CXX=$compiler
export PATH CMAKE_PREFIX_PATH CXX

fail() { echo "FAILED: $1" >&2; exit 1; }

mkdir "$work/new"
cd "$work/new"

# 1. the plugin
graft new-plugin ranging >wrote || fail "new-plugin"

# Lines of one's own: an edge of three vertices, ...
cat >edge <<'LINES'
struct Middle : Edge<Middle, 1, RangingPosition, RangingPosition, RangingPosition> {
  static constexpr auto tag = "RANGING_MIDDLE";
  static constexpr auto doc = "the second lies in the middle of the others";
  template <class T>
  Vec<T, 1> error(const RangingPosition<T>& a, const RangingPosition<T>& b,
                  const RangingPosition<T>& c) const {
    return b.coordinates - (a.coordinates + c.coordinates) * 0.5;
  }
};
LINES
# ... its registration, ...
echo '  registry.add<Middle>();' >registration
# ... and a graph: positions measured at 0 and 3, a third in their middle.
cat >graph.g2o <<'LINES'
RANGING_PRIOR 0 0 1
RANGING_PRIOR 2 3 1
RANGING_MIDDLE 0 1 2 1
LINES
own=$(cat edge registration graph.g2o | wc -l)
[ "$own" -le 15 ] || fail "$own lines of one's own"
sed -i -e '/^\/\/ Your types go here/r edge' -e '/registry.add<RangingDifference>/r registration' \
  ranging/plugin.cpp

# 2. and 3. build
"$cmake" -S ranging -B ranging/build >log 2>&1 || { cat log; fail "configure"; }
"$cmake" --build ranging/build >log 2>&1 || { cat log; fail "build"; }
# 4. solve
graft optimize graph.g2o --plugin ranging/build/libgraft_ranging.so -o solved.g2o >summary ||
  fail "optimize"
awk '$1 == "VERTEX_RANGING" { v[$2] = $3 }
     function off(a, b) { d = a - b; return d < 0 ? -d : d }
     END { exit !(off(v[0], 0) < 1e-6 && off(v[1], 1.5) < 1e-6 && off(v[2], 3) < 1e-6) }' \
  solved.g2o || { cat solved.g2o; fail "not the optimum by hand"; }

# Its tests pass, the new edge's conformance among them.
"${cmake%cmake}ctest" --test-dir ranging/build --output-on-failure >tests.log 2>&1 ||
  { cat tests.log; fail "the new plugin's tests"; }
grep -q "conformance.ranging .*Passed" tests.log || { cat tests.log; fail "no conformance test"; }
grep -q "unit.ranging .*Passed" tests.log || { cat tests.log; fail "no unit test"; }
graft check-plugin ranging/build/libgraft_ranging.so | grep -q "RANGING_MIDDLE" ||
  fail "the new edge is not checked"
# They can fail: a wrong sign in the edge that the unit test knows.
sed -i 's/return b.coordinates - a.coordinates -/return b.coordinates + a.coordinates -/' \
  ranging/plugin.cpp
"$cmake" --build ranging/build >log 2>&1 || { cat log; fail "second build"; }
if "${cmake%cmake}ctest" --test-dir ranging/build -R unit >/dev/null 2>&1; then
  fail "the unit test does not see a wrong sign"
fi

# The example of the generated README, and every word filled in.
graft new-plugin my_edges_2 -o other >/dev/null
if grep -rn "@[A-Z]*@" other; then fail "a word is not filled in"; fi
grep -q "struct MyEdges2Prior" other/plugin.cpp || fail "camel case"
echo "new-plugin test passed"
