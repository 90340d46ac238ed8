// SPDX-License-Identifier: BSD-3-Clause
#include "core/linear/block_product.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

namespace graft::testing {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Every dimension up to 10, columns in the middle and at the very end of the matrix.
TEST(BlockProduct, IsThatOfEigenAndWritesNothingElse) {
  constexpr double kMark = 12345;
  for (int errors = 1; errors <= 7; ++errors) {
    for (int rows = 1; rows <= 10; ++rows) {
      for (int columns = 1; columns <= 10; ++columns) {
        const int stride = rows + columns + 3;
        const RowMajor m = RowMajor::Random(errors, stride);
        const Eigen::MatrixXd before = Eigen::MatrixXd::Random(rows, columns);
        for (const int a : {0, stride - rows}) {
          const int b = a == 0 ? stride - columns : 1;
          const Eigen::MatrixXd expected =
              before + m.middleCols(a, rows).transpose() * m.middleCols(b, columns);
          for (const auto choose : {&blockProduct, &portableBlockProduct}) {
            std::vector<double> out(before.data(), before.data() + before.size());
            out.push_back(kMark);
            choose(errors, rows, columns)(m.data() + a, m.data() + b, errors, rows, columns, stride,
                                          out.data());
            const Eigen::Map<const Eigen::MatrixXd> found(out.data(), rows, columns);
            EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-14 * errors)
                << errors << ", " << rows << " x " << columns;
            EXPECT_EQ(out.back(), kMark);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace graft::testing
