// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/convert_formats.hpp"

#include <Eigen/LU>

#include "core/base/text.hpp"
#include "core/geometry/euler.hpp"
#include "core/geometry/se3.hpp"

namespace graft {

namespace {

void appendNumbers(std::string& out, const double* numbers, int count) {
  for (int i = 0; i < count; ++i) {
    out += ' ';
    appendDouble(out, numbers[i]);
  }
}

/// The pose that a vertex is, if it is one.
bool poseOf(const std::string& tag, const double* x, Pose& pose) {
  if (tag == "VERTEX_SE3:QUAT") {
    pose = Pose::fromArray(x);
  } else if (tag == "VERTEX_SE2") {
    pose = Pose(Vec<double, 3>(x[0], x[1], 0), quaternionOfEuler(0.0, 0.0, x[2]));
  } else if (tag == "VERTEX3") {
    pose = Pose(Vec<double, 3>(x[0], x[1], x[2]), quaternionOfEuler(x[3], x[4], x[5]));
  } else {
    return false;
  }
  return true;
}

template <class Line>
Converted formatPoses(const LoadedGraph& loaded, const Line& line) {
  Converted converted;
  for (const VertexRef v : loaded.graph.verticesById()) {
    const std::string tag = loaded.graph.type(v).tag;
    Pose pose;
    if (poseOf(tag, loaded.values.at(v), pose)) {
      line(loaded.graph.id(v), pose, converted.text);
    } else {
      ++converted.left_out[tag];
    }
  }
  return converted;
}

void appendEuler(std::string& out, const Pose& pose) {
  const Vec<double, 3> euler = eulerOfQuaternion(pose.rotation);
  appendNumbers(out, pose.translation.data(), 3);
  appendNumbers(out, euler.data(), 3);
}

/// The information of Euler angles that EDGE_SE3:QUAT's is, upper triangle.
void appendEulerInformation(std::string& out, const Pose& measured, const double* upper) {
  Mat<double, 6> omega;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) omega(r, c) = omega(c, r) = *upper++;
  }
  Mat<double, 6> inverse = Mat<double, 6>::Identity();
  inverse.bottomRightCorner<3, 3>() = eulerByQuaternionVector(measured.rotation).inverse();
  const Mat<double, 6> euler = inverse.transpose() * omega * inverse;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) {
      const double entry = 0.5 * (euler(r, c) + euler(c, r));
      appendNumbers(out, &entry, 1);
    }
  }
}

bool appendToroEdge(const std::string& tag, const std::string& ids, const double* z,
                    const double* upper, std::string& out) {
  if (tag == "EDGE_SE2") {
    out += "EDGE2" + ids;
    appendNumbers(out, z, 3);
    const double order[6] = {upper[0], upper[1], upper[3], upper[5], upper[2], upper[4]};
    appendNumbers(out, order, 6);
  } else if (tag == "EDGE_SE3:QUAT") {
    const Pose measured = Pose::fromArray(z);
    out += "EDGE3" + ids;
    appendEuler(out, measured);
    appendEulerInformation(out, measured, upper);
  } else if (tag == "EDGE3") {
    out += "EDGE3" + ids;
    appendNumbers(out, z, 6);
    appendNumbers(out, upper, 21);
  } else {
    return false;
  }
  out += '\n';
  return true;
}

}  // namespace

Converted formatTumPoses(const LoadedGraph& loaded) {
  return formatPoses(loaded, [](std::int64_t id, const Pose& pose, std::string& out) {
    double numbers[7];
    pose.toArray(numbers);
    out += std::to_string(id);
    appendNumbers(out, numbers, 7);
    out += '\n';
  });
}

Converted formatKittiPoses(const LoadedGraph& loaded) {
  return formatPoses(loaded, [](std::int64_t, const Pose& pose, std::string& out) {
    const Mat<double, 3> r = pose.rotation.toRotationMatrix();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 4; ++j) {
        if (i + j > 0) out += ' ';
        appendDouble(out, j < 3 ? r(i, j) : pose.translation[i]);
      }
    }
    out += '\n';
  });
}

Converted formatToro(const LoadedGraph& loaded) {
  const Graph& graph = loaded.graph;
  Converted converted;
  std::string& out = converted.text;
  for (const VertexRef v : graph.verticesById()) {
    const std::string tag = graph.type(v).tag;
    const std::string id = ' ' + std::to_string(graph.id(v));
    const double* x = loaded.values.at(v);
    if (graph.isFixed(v)) ++converted.left_out["FIX"];
    if (tag == "VERTEX_SE2") {
      out += "VERTEX2" + id;
      appendNumbers(out, x, 3);
    } else if (tag == "VERTEX_SE3:QUAT") {
      out += "VERTEX3" + id;
      appendEuler(out, Pose::fromArray(x));
    } else if (tag == "VERTEX3") {
      out += "VERTEX3" + id;
      appendNumbers(out, x, 6);
    } else {
      ++converted.left_out[tag];
      continue;
    }
    out += '\n';
  }
  for (const EdgeBlock& block : graph.edgeBlocks()) {
    for (std::size_t e = 0; e < block.size(); ++e) {
      std::string ids;
      for (auto k = block.vertex_begin[e]; k < block.vertex_begin[e + 1]; ++k) {
        ids += ' ' + std::to_string(graph.id(block.vertices[std::size_t(k)]));
      }
      const double* z = block.measurements.data() + block.measurement_begin[e];
      const double* upper = block.information.data() + block.information_begin[e];
      if (!appendToroEdge(block.type->tag, ids, z, upper, out)) {
        ++converted.left_out[block.type->tag];
      }
      if (block.kernels[e] >= 0) ++converted.left_out["ROBUST_KERNEL"];
      if (block.levels[e] != 0) ++converted.left_out["G2O_EDGE_LEVEL"];
    }
  }
  return converted;
}

}  // namespace graft
