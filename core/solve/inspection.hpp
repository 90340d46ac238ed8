// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/solve/normal_equations.hpp"
#include "core/solve/problem.hpp"
#include "core/types/registry.hpp"

namespace graft {

/// The edge of a tag whose Jacobian differs most from differences of its error.
struct JacobianCheck {
  std::string tag;
  std::int64_t edges = 0;
  double worst = 0;             ///< largest difference, relative to 1 + the largest entry
  std::string worst_edge;       ///< "TAG ids (line n)"
  std::int64_t suspicious = 0;  ///< edges beyond kJacobianTolerance
};
constexpr double kJacobianTolerance = 1e-5;

/// Compares every edge's Jacobian at the values with central differences of its
/// error (two steps, Richardson; the better of two step sizes counts, for a jump
/// of an angle near by is no fault). One entry per tag. Throws Error(kNoResult)
/// where an edge cannot be evaluated.
std::vector<JacobianCheck> checkJacobians(const Problem& problem, const Values& values);

/// An edge that weighs very differently from the others of its tag.
struct OddWeight {
  std::string edge;  ///< "TAG ids (line n)"
  double ratio = 1;  ///< of an entry of its information's diagonal to the tag's median
};
constexpr double kOddWeight = 1e3;

/// Edges with a diagonal entry of the information more than kOddWeight times
/// larger or smaller than the median of that entry over its tag and shape, where
/// there are at least five; most extreme first. Zeros do not count.
std::vector<OddWeight> findOddWeights(const Problem& problem);

/// What the edges leave open at a vertex.
struct FreeDirection {
  VertexRef vertex;
  Eigen::VectorXd direction;  ///< unit, in the vertex's tangent
  double share = 1;           ///< of this vertex in the motion, 1 = it moves alone
};

/// Directions that no edge resists at the values, after what is fixed and held:
/// the null space of the normal equations, by vertex. Empty where the system
/// determines everything. First those in which a vertex moves alone, by rising id;
/// then shares in motions of several vertices, largest first. Of such motions at
/// most twelve are looked for, and shares below a tenth are left out unless there
/// are none above.
std::vector<FreeDirection> findFreeDirections(const Problem& problem, const Values& values);

/// "VERTEX_XY 2 is free along (1 x)": the numbers' names where a type's tangent has the
/// same as its estimate, else their places.
std::string describe(const Problem& problem, const FreeDirection& free);

/// Texts of findFreeDirections(), at most `limit` and then how many more; empty also where
/// the edges cannot be evaluated.
std::vector<std::string> describeFreeDirections(const Problem& problem, const Values& values,
                                                std::size_t limit = 20);

/// True where the edges leave a single vertex a direction of its own: its block of J'J is
/// singular. Cheap; what several vertices can do together only findFreeDirections() sees.
bool hasOpenBlock(const NormalEquations& equations);

/// True where all that holds a connected component are edges of arity 1 of which none
/// measures a whole vertex (e.g. one position of a pose): what is left may be free. Looks
/// at dimensions and information matrices only; findFreeDirections() tells.
bool hasWeakAnchor(const Problem& problem);

}  // namespace graft
