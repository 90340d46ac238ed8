// SPDX-License-Identifier: BSD-3-Clause
#include "types_lfd/model/model_file.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.hpp"
#include "core/base/file.hpp"

namespace graft::lfd {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "graft motion model";
constexpr int kVersion = 1;
constexpr std::size_t kMaximumBytes = std::size_t{256} << 20;
constexpr int kDimension = 1 + kStateDimension;
constexpr const char* kDimensions[kDimension] = {
    "t",          "gripper_x",  "gripper_y", "gripper_z", "gripper_rx",
    "gripper_ry", "gripper_rz", "base_x",    "base_y",    "base_yaw"};
constexpr const char* kAxes[3] = {"x", "y", "z"};

template <class Vector>
Json numbers(const Vector& v) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) list.push_back(static_cast<double>(v[i]));
  return list;
}

/// Indented text in which a list of plain values stays on one line, so that a
/// covariance reads as a matrix.
void appendReadable(const Json& value, const std::string& indent, std::string& out) {
  const bool nested =
      value.is_object() || (value.is_array() && !value.empty() && value[0].is_structured());
  if (!nested) {
    out += value.dump(-1, ' ', false, Json::error_handler_t::replace);
    return;
  }
  const std::string inner = indent + " ";
  out += value.is_object() ? "{" : "[";
  const char* separator = "\n";
  for (const auto& item : value.items()) {
    out += separator + inner;
    if (value.is_object()) out += Json(item.key()).dump() + ": ";
    appendReadable(item.value(), inner, out);
    separator = ",\n";
  }
  out += "\n" + indent + (value.is_object() ? "}" : "]");
}

Json formatSegment(const SegmentModel& segment) {
  Json out;
  out["name"] = segment.name;
  out["duration"] = segment.duration;
  out["demonstrations"] = segment.demonstrations;
  out["samples"] = segment.samples;
  out["gripper_frame"] = "object at the grasp";
  out["base_frame"] = "floor below the object at the grasp";
  out["heading_axis"] = kAxes[segment.chart.heading_axis];
  out["orientation_chart"] = "rotation vector at the mean";
  out["orientation_mean"] = numbers(segment.chart.orientation_mean.coeffs());
  out["dimensions"] = kDimensions;
  out["start"] = numbers(segment.start);
  out["end"] = numbers(segment.end);
  Json priors = Json::array();
  Json means = Json::array();
  Json covariances = Json::array();
  for (const GaussianComponent& c : segment.mixture.components) {
    priors.push_back(c.weight);
    means.push_back(numbers(c.mean));
    Json rows = Json::array();
    for (Eigen::Index i = 0; i < c.covariance.rows(); ++i) {
      rows.push_back(numbers(c.covariance.row(i)));
    }
    covariances.push_back(rows);
  }
  out["priors"] = priors;
  out["means"] = means;
  out["covariances"] = covariances;
  Json selection = Json::array();
  for (const ComponentScore& s : segment.selection) {
    Json point;
    point["components"] = s.components;
    point["log_likelihood"] = s.log_likelihood;
    point["bic"] = s.bic;
    point["aic"] = s.aic;
    point["iterations"] = s.iterations;
    point["converged"] = s.converged;
    selection.push_back(point);
  }
  out["selection"] = selection;
  return out;
}

/// A value of the file together with its name in it, e.g. segments[0].priors.
class Field {
 public:
  Field(const Json& value, std::string name, const std::string& path)
      : value_(value), name_(std::move(name)), path_(path) {}

  [[noreturn]] void fail(const std::string& text) const {
    throw Error(ExitCode::kInput, {path_, 0, 0}, (name_.empty() ? "the file" : name_) + " " + text);
  }
  void allow(const std::set<std::string>& keys) const {
    if (!value_.is_object()) fail("must be an object");
    for (const auto& item : value_.items()) {
      if (keys.count(item.key()) == 0) {
        fail("has an unknown field " + graft::quoted(item.key()));
      }
    }
  }
  Field operator[](const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end()) fail(std::string("needs the field '") + key + "'");
    return Field(*found, name_.empty() ? key : name_ + "." + key, path_);
  }
  std::vector<Field> list(std::size_t size = 0) const {
    if (!value_.is_array()) fail("must be a list");
    if (size != 0 && value_.size() != size) {
      fail("must have " + std::to_string(size) + " entries, not " + std::to_string(value_.size()));
    }
    std::vector<Field> result;
    for (std::size_t i = 0; i < value_.size(); ++i) {
      result.emplace_back(value_[i], name_ + "[" + std::to_string(i) + "]", path_);
    }
    return result;
  }
  double number() const {
    if (!value_.is_number()) fail("must be a number");
    return value_.get<double>();
  }
  int integer(int minimum) const {
    if (!value_.is_number_integer() || value_ < minimum || value_ > 1000000000) {
      fail("must be an integer of at least " + std::to_string(minimum));
    }
    return value_.get<int>();
  }
  bool boolean() const {
    if (!value_.is_boolean()) fail("must be true or false");
    return value_.get<bool>();
  }
  std::string text() const {
    if (!value_.is_string()) fail("must be a text");
    return value_.get<std::string>();
  }
  void mustBe(const char* expected) const {
    if (text() != expected)
      fail("must be '" + std::string(expected) + "', not " + graft::quoted(text()));
  }
  Eigen::VectorXd vector(int size) const {
    const auto fields = list(static_cast<std::size_t>(size));
    Eigen::VectorXd v(size);
    for (int i = 0; i < size; ++i) v[i] = fields[static_cast<std::size_t>(i)].number();
    return v;
  }

 private:
  const Json& value_;
  std::string name_;
  const std::string& path_;
};

Eigen::MatrixXd readCovariance(const Field& field) {
  const auto rows = field.list(kDimension);
  Eigen::MatrixXd m(kDimension, kDimension);
  for (int i = 0; i < kDimension; ++i) {
    m.row(i) = rows[static_cast<std::size_t>(i)].vector(kDimension).transpose();
  }
  const double size = m.cwiseAbs().maxCoeff();
  if ((m - m.transpose()).cwiseAbs().maxCoeff() > 1e-12 * size) field.fail("must be symmetric");
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(m, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues()[0] >= -1e-12 * size) || !(m(0, 0) > 0)) {
    field.fail("must be positive semidefinite with a positive variance of t");
  }
  return m;
}

GaussianMixture readMixture(const Field& segment) {
  const auto priors = segment["priors"].list();
  if (priors.empty()) segment["priors"].fail("must not be empty");
  const auto means = segment["means"].list(priors.size());
  const auto covariances = segment["covariances"].list(priors.size());
  GaussianMixture mixture;
  double sum = 0;
  for (std::size_t k = 0; k < priors.size(); ++k) {
    GaussianComponent c;
    c.weight = priors[k].number();
    if (!(c.weight > 0)) priors[k].fail("must be positive");
    sum += c.weight;
    c.mean = means[k].vector(kDimension);
    c.covariance = readCovariance(covariances[k]);
    mixture.components.push_back(std::move(c));
  }
  if (std::abs(sum - 1) > 1e-9) segment["priors"].fail("must sum to 1");
  return mixture;
}

SegmentChart readChart(const Field& segment) {
  segment["gripper_frame"].mustBe("object at the grasp");
  segment["base_frame"].mustBe("floor below the object at the grasp");
  segment["orientation_chart"].mustBe("rotation vector at the mean");
  const auto names = segment["dimensions"].list(kDimension);
  for (std::size_t i = 0; i < names.size(); ++i) names[i].mustBe(kDimensions[i]);

  SegmentChart chart;
  const std::string axis = segment["heading_axis"].text();
  chart.heading_axis = -1;
  for (int i = 0; i < 3; ++i) {
    if (axis == kAxes[i]) chart.heading_axis = i;
  }
  if (chart.heading_axis < 0) segment["heading_axis"].fail("must be 'x', 'y' or 'z'");
  const Eigen::VectorXd q = segment["orientation_mean"].vector(4);
  if (std::abs(q.norm() - 1) > 1e-9) segment["orientation_mean"].fail("must have length 1");
  chart.orientation_mean.coeffs() = q;
  return chart;
}

SegmentModel readSegment(const Field& field) {
  field.allow({"name", "duration", "demonstrations", "samples", "gripper_frame", "base_frame",
               "heading_axis", "orientation_chart", "orientation_mean", "dimensions", "start",
               "end", "priors", "means", "covariances", "selection"});
  SegmentModel segment;
  segment.name = field["name"].text();
  if (segment.name.empty()) field["name"].fail("must not be empty");
  segment.duration = field["duration"].number();
  if (!(segment.duration > 0)) field["duration"].fail("must be positive");
  segment.demonstrations = field["demonstrations"].integer(1);
  segment.samples = field["samples"].integer(1);
  segment.chart = readChart(field);
  segment.start = field["start"].vector(kStateDimension);
  segment.end = field["end"].vector(kStateDimension);
  segment.mixture = readMixture(field);
  for (const Field& point : field["selection"].list()) {
    point.allow({"components", "log_likelihood", "bic", "aic", "iterations", "converged"});
    ComponentScore score;
    score.components = point["components"].integer(1);
    score.log_likelihood = point["log_likelihood"].number();
    score.bic = point["bic"].number();
    score.aic = point["aic"].number();
    score.iterations = point["iterations"].integer(0);
    score.converged = point["converged"].boolean();
    segment.selection.push_back(score);
  }
  return segment;
}

/// Parses JSON in which no object names a field twice.
Json parseStrictly(const std::string& text, const std::string& path) {
  std::vector<std::set<std::string>> keys;
  const auto watch = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key) {
      const auto name = parsed.get<std::string>();
      if (!keys.back().insert(name).second) {
        throw Error(ExitCode::kInput, {path, 0, 0},
                    "the field " + graft::quoted(name) + " occurs twice");
      }
    }
    return true;
  };
  try {
    return Json::parse(text, watch);
  } catch (const Json::parse_error& e) {
    SourceLocation where{path, 1, 1};
    for (std::size_t i = 0; i + 1 < e.byte && i < text.size(); ++i) {
      where.column = text[i] == '\n' ? 1 : where.column + 1;
      where.line += text[i] == '\n' ? 1 : 0;
    }
    throw Error(ExitCode::kInput, where, "not valid JSON");
  } catch (const Json::exception&) {
    throw Error(ExitCode::kInput, {path, 0, 0}, "a number is out of range");
  }
}

}  // namespace

std::string formatModel(const MotionModel& model) {
  Json out;
  out["format"] = kFormat;
  out["version"] = kVersion;
  out["task"] = model.task;
  out["segments"] = Json::array();
  for (const SegmentModel& segment : model.segments) {
    out["segments"].push_back(formatSegment(segment));
  }
  std::string text;
  appendReadable(out, "", text);
  return text + "\n";
}

MotionModel parseModel(const std::string& text, const std::string& path) {
  const Json json = parseStrictly(text, path);
  const Field file(json, "", path);
  file.allow({"format", "version", "task", "segments"});
  file["format"].mustBe(kFormat);
  if (file["version"].integer(1) != kVersion) file["version"].fail("must be 1");
  MotionModel model;
  model.task = file["task"].text();
  for (const Field& segment : file["segments"].list()) {
    model.segments.push_back(readSegment(segment));
  }
  if (model.segments.empty()) file["segments"].fail("must not be empty");
  return model;
}

MotionModel readModel(const std::string& path) {
  return parseModel(readFile(path, kMaximumBytes), path);
}

}  // namespace graft::lfd
