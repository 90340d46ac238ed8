// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/mixture_file.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/base/file.hpp"
#include "core/base/text.hpp"

namespace graft::lfd {

namespace {

constexpr int kDimension = 15;
constexpr std::size_t kMaximumBytes = std::size_t{64} << 20;
constexpr int kMostComponents = 1000;
constexpr const char* kRows[kDimension] = {"t", "x", "y", "z",  "qx", "qy", "qz", "qw",
                                           "x", "y", "z", "qx", "qy", "qz", "qw"};
/// Variance along the quaternion itself above which a component holds both
/// signs; a spread of orientations of one sign by 40 degrees gives a tenth of it.
constexpr double kMixedSigns = 0.05;

/// Reads the file line by line, blank lines left out.
class MixtureReader {
 public:
  MixtureReader(const std::string& text, const std::string& path) : lines_(text), path_(path) {}

  [[noreturn]] void fail(std::int64_t column, const std::string& text) const {
    throw Error(ExitCode::kInput, {path_, lines_.lineNumber(), column}, text);
  }

  /// Moves to the next line that is not blank and checks its first word.
  LineTokens expect(const std::string& word) {
    std::string_view line;
    while (lines_.next(line)) {
      LineTokens tokens(line);
      const std::string_view first = tokens.next();
      if (first.empty()) continue;
      if (first != word) {
        fail(tokens.column(), "expected " + word + ", found " + quoted(first));
      }
      return tokens;
    }
    throw Error(ExitCode::kInput, {path_, lines_.lineNumber(), 0},
                "the file ends where " + word + " should follow");
  }
  void heading(const std::string& name) {
    LineTokens tokens = expect("\"" + name + "\"");
    finish(tokens);
  }
  /// The numbers of a line that begins with `label`; `count` of them (0 = any).
  std::vector<double> numbers(const std::string& label, std::size_t count) {
    LineTokens tokens = expect(label);
    std::vector<double> values;
    while (!tokens.atEnd()) {
      const std::string_view token = tokens.next();
      double value = 0;
      const NumberStatus status = parseDouble(token, value);
      if (status != NumberStatus::kOk) fail(tokens.column(), describe(status, token));
      values.push_back(value);
    }
    if (count != 0 ? values.size() != count : values.empty()) {
      fail(0, "row '" + label + "' has " + std::to_string(values.size()) + " numbers" +
                  (count != 0 ? ", not " + std::to_string(count) : std::string()));
    }
    return values;
  }
  void finish(LineTokens& tokens) const {
    if (!tokens.atEnd()) {
      const std::string extra(tokens.next());
      fail(tokens.column(), "unexpected " + quoted(extra));
    }
  }
  void expectEnd() {
    std::string_view line;
    while (lines_.next(line)) {
      LineTokens tokens(line);
      finish(tokens);
    }
  }

 private:
  LineReader lines_;
  const std::string& path_;
};

/// Symmetric, negative eigenvalues at zero; returns how many there were.
int repairCovariance(Eigen::MatrixXd& m) {
  m = 0.5 * (m + m.transpose()).eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(m);
  int negative = 0;
  for (const double value : eigen.eigenvalues()) negative += value < 0 ? 1 : 0;
  if (negative > 0) {
    m = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
        eigen.eigenvectors().transpose();
    m = 0.5 * (m + m.transpose()).eval();
  }
  return negative;
}

Eigen::Quaterniond quaternionOf(const Eigen::VectorXd& v, Eigen::Index first) {
  return Eigen::Quaterniond(Vec<double, 4>(v.segment<4>(first))).normalized();
}

/// Jacobian (3 x 4) of log(mean^-1 q) at v, for changes of the numbers of q: the
/// part of a change along q is none of rotation.
Mat<double, 3, 4> chartJacobian(const Eigen::Quaterniond& q, const Vec<double, 3>& v) {
  Mat<double, 3, 4> body;  // 2 vec(q^-1 dq)
  body << q.w(), q.z(), -q.y(), -q.x(), -q.z(), q.w(), q.x(), -q.y(), q.y(), -q.x(), q.w(), -q.z();
  return 2 * inverseRightJacobianSO3(v) * body;
}

bool hasMixedSigns(const GaussianComponent& c, Eigen::Index first) {
  const Vec<double, 4> q = quaternionOf(c.mean, first).coeffs();
  return q.dot(c.covariance.block<4, 4>(first, first) * q) > kMixedSigns;
}

/// A few rows and columns of a covariance without any relation to the others.
void separate(Eigen::MatrixXd& covariance, Eigen::Index first, Eigen::Index count) {
  const Eigen::MatrixXd own = covariance.block(first, first, count, count);
  covariance.middleRows(first, count).setZero();
  covariance.middleCols(first, count).setZero();
  covariance.block(first, first, count, count) = own;
}

}  // namespace

MixtureFile parseMixtureFile(const std::string& text, const std::string& path,
                             Diagnostics& diagnostics) {
  MixtureReader reader(text, path);
  MixtureFile file;
  reader.heading("Priors");
  const auto priors = reader.numbers("p", 0);
  if (priors.size() > kMostComponents) reader.fail(0, "more than 1000 components");
  double sum = 0;
  for (const double p : priors) {
    if (!(p > 0)) reader.fail(0, "priors must be positive");
    sum += p;
  }
  if (std::abs(sum - 1) > 1e-6) {
    diagnostics.warning({path, 0, 0}, "priors sum to " + formatDouble(sum) + ": scaled to 1");
  }
  for (const double p : priors) {
    file.mixture.components.push_back(
        {p / sum, Eigen::VectorXd(kDimension), Eigen::MatrixXd(kDimension, kDimension)});
  }
  reader.heading("Mu");
  for (int row = 0; row < kDimension; ++row) {
    const auto values = reader.numbers(kRows[row], priors.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      file.mixture.components[k].mean[row] = values[k];
    }
    if (row != 7 && row != 14) continue;
    for (const GaussianComponent& c : file.mixture.components) {
      if (std::abs(c.mean.segment<4>(row - 3).norm() - 1) > 0.01) {
        reader.fail(0, "the quaternion of a mean does not have length 1");
      }
    }
  }
  int negative = 0;
  for (std::size_t k = 0; k < priors.size(); ++k) {
    reader.heading("Sigma" + std::to_string(k + 1));
    Eigen::MatrixXd& m = file.mixture.components[k].covariance;
    for (int row = 0; row < kDimension; ++row) {
      const auto values = reader.numbers("s", kDimension);
      if (row == 0 && !(values[0] > 0)) reader.fail(0, "the variance of t must be positive");
      m.row(row) = Eigen::Map<const Eigen::RowVectorXd>(values.data(), kDimension);
    }
    if ((m - m.transpose()).cwiseAbs().maxCoeff() > 1e-3 * (1 + m.cwiseAbs().maxCoeff())) {
      reader.fail(0, "Sigma" + std::to_string(k + 1) + " is not symmetric");
    }
    negative += repairCovariance(m);
  }
  if (negative > 0) {
    diagnostics.warning({path, 0, 0},
                        std::to_string(negative) + " negative eigenvalues of covariances set to 0");
  }
  reader.heading("Related_Object");
  auto pose = reader.numbers("pose", 7);
  if (const char* why = Pose::normalize(pose.data())) reader.fail(0, why);
  file.model_T_object = Pose::fromArray(pose.data());
  const auto grasp = reader.numbers("grasp", 3);
  file.grasp = Vec<double, 3>(grasp[0], grasp[1], grasp[2]);
  LineTokens name = reader.expect("name");
  file.object_name = std::string(name.next());
  if (file.object_name.empty()) reader.fail(0, "the object has no name");
  reader.finish(name);
  reader.expectEnd();
  return file;
}

MixtureFile readMixtureFile(const std::string& path, Diagnostics& diagnostics) {
  return parseMixtureFile(readFile(path, kMaximumBytes), path, diagnostics);
}

SegmentModel toSegmentModel(const MixtureFile& file, const std::string& name, double duration,
                            Diagnostics& diagnostics) {
  const auto& source = file.mixture.components;
  const double last = source.empty() ? 0 : source.back().mean[0];
  if (!(last > 0) || source.front().mean[0] < -1e-9) {
    throw Error(ExitCode::kInput, "mixture '" + name + "': the means of t do not rise from 0");
  }
  SegmentModel model;
  model.name = name;
  model.duration = duration;
  const Pose object_T_model = file.model_T_object.inverse();
  model.chart.heading_axis = mostLevelAxis({file.model_T_object});
  const Pose2 heading_T_model =
      headingFrame(file.model_T_object, model.chart.heading_axis).inverse();
  std::vector<Eigen::Quaterniond> rotations;
  rotations.reserve(source.size());
  for (const GaussianComponent& c : source) {
    rotations.push_back(object_T_model.rotation * quaternionOf(c.mean, 4));
  }
  model.chart.orientation_mean = meanRotation(rotations);

  int mixed = 0;
  MotionState previous;
  for (std::size_t k = 0; k < source.size(); ++k) {
    const GaussianComponent& c = source[k];
    if (k > 0 && c.mean[0] < source[k - 1].mean[0]) {
      throw Error(ExitCode::kInput, "mixture '" + name + "': the means of t do not rise from 0");
    }
    const Pose gripper(c.mean.segment<3>(1), quaternionOf(c.mean, 4));
    const Pose2 base(c.mean[8], c.mean[9], 2 * std::atan2(c.mean[13], c.mean[14]));
    const MotionState state =
        k == 0 ? model.chart.encode(gripper, base, file.model_T_object)
               : model.chart.encode(gripper, base, file.model_T_object, previous);
    previous = state;

    Eigen::MatrixXd map = Eigen::MatrixXd::Zero(1 + kStateDimension, kDimension);
    map(0, 0) = 1 / last;
    map.block<3, 3>(1, 1) = object_T_model.rotation.toRotationMatrix();
    map.block<3, 4>(4, 4) = chartJacobian(quaternionOf(c.mean, 4), state.segment<3>(3));
    const double turn = heading_T_model.theta;
    map.block<2, 2>(7, 8) << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
    const double length2 = c.mean[13] * c.mean[13] + c.mean[14] * c.mean[14];
    map(9, 13) = 2 * c.mean[14] / length2;
    map(9, 14) = -2 * c.mean[13] / length2;

    GaussianComponent out;
    out.weight = c.weight;
    out.mean = Eigen::VectorXd(1 + kStateDimension);
    out.mean << c.mean[0] / last, state;
    out.covariance = map * c.covariance * map.transpose();
    out.covariance = 0.5 * (out.covariance + out.covariance.transpose()).eval();
    if (hasMixedSigns(c, 4)) {
      separate(out.covariance, 4, 3);
      ++mixed;
    }
    if (hasMixedSigns(c, 11)) {
      separate(out.covariance, 9, 1);
      ++mixed;
    }
    model.mixture.components.push_back(std::move(out));
  }
  if (mixed > 0) {
    diagnostics.note({}, "mixture '" + name + "': " + std::to_string(mixed) +
                             " orientations were fitted to quaternions of both signs; their "
                             "covariance with time is dropped");
  }
  model.start = model.mixture.components.front().mean.tail<kStateDimension>();
  model.end = model.mixture.components.back().mean.tail<kStateDimension>();
  model.demonstrations = 1;
  model.samples = 1;
  return model;
}

}  // namespace graft::lfd
