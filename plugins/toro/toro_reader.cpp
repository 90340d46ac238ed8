// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/toro/toro_reader.hpp"

#include <string>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/geometry/euler.hpp"

namespace graft::toro {

namespace {

enum class Tag { kVertex2, kEdge2, kVertex3, kEdge3, kOther };

Tag tagOf(std::string_view name) {
  if (name == "VERTEX2") return Tag::kVertex2;
  if (name == "EDGE2") return Tag::kEdge2;
  if (name == "VERTEX3") return Tag::kVertex3;
  if (name == "EDGE3") return Tag::kEdge3;
  return Tag::kOther;
}

class Reader {
 public:
  Reader(std::string_view text, const graft_graph_sink& sink) : lines_(text), sink_(sink) {}

  bool run() {
    std::string_view line;
    while (!stopped_ && lines_.next(line)) {
      LineTokens tokens(line);
      const std::string_view name = tokens.next();
      if (name.empty()) continue;
      name_ = name;
      empty_ = false;
      switch (tagOf(name)) {
        case Tag::kVertex2:
          vertex(tokens, 3);
          break;
        case Tag::kVertex3:
          vertex(tokens, 6);
          break;
        case Tag::kEdge2:
          edge(tokens, 3, 6);
          break;
        case Tag::kEdge3:
          edge(tokens, 6, 21);
          break;
        case Tag::kOther:
          fail(tokens, "unknown tag " + graft::quoted(name) +
                           ", TORO has VERTEX2, EDGE2, VERTEX3 and EDGE3");
      }
    }
    if (empty_) {
      good_ = false;
      sink_.report(sink_.host, 2, nullptr, 1, 0, "there is no vertex and no edge");
    }
    return good_;
  }

 private:
  void fail(const LineTokens& tokens, const std::string& text) {
    good_ = false;
    sink_.report(sink_.host, 2, nullptr, lines_.lineNumber(), tokens.column(), text.c_str());
  }
  void check(int status) { stopped_ = stopped_ || status != GRAFT_OK; }

  bool id(LineTokens& tokens, std::int64_t& value) {
    const std::string_view token = tokens.next();
    if (parseInteger(token, value) == NumberStatus::kOk && value >= 0) return true;
    fail(tokens,
         "expected an id, got " + (token.empty() ? "the end of the line" : graft::quoted(token)));
    return false;
  }

  /// Reads `count` numbers and the end of the line.
  bool numbers(LineTokens& tokens, int count, double* values) {
    for (int i = 0; i < count; ++i) {
      const std::string_view token = tokens.next();
      const NumberStatus status = parseDouble(token, values[i]);
      if (status == NumberStatus::kOk) continue;
      fail(tokens, std::string(name_) + ": " + describe(status, token));
      return false;
    }
    const std::string_view extra = tokens.next();
    if (extra.empty()) return true;
    fail(tokens, "unexpected token " + graft::quoted(extra) + " after the numbers of " +
                     std::string(name_));
    return false;
  }

  static void quaternionPose(const double* euler, double* pose) {
    const Eigen::Quaterniond q = quaternionOfEuler(euler[3], euler[4], euler[5]).normalized();
    for (int i = 0; i < 3; ++i) pose[i] = euler[i];
    for (int i = 0; i < 4; ++i) pose[3 + i] = q.coeffs()[i];
  }

  void vertex(LineTokens& tokens, int count) {
    std::int64_t name = 0;
    double values[6];
    if (!id(tokens, name) || !numbers(tokens, count, values)) return;
    if (count == 3) {
      return check(
          sink_.add_vertex(sink_.host, "VERTEX_SE2", name, values, 3, lines_.lineNumber()));
    }
    double pose[7];
    quaternionPose(values, pose);
    check(sink_.add_vertex(sink_.host, "VERTEX_SE3:QUAT", name, pose, 7, lines_.lineNumber()));
  }

  void edge(LineTokens& tokens, int count, int entries) {
    std::int64_t ids[2] = {};
    double values[27];
    if (!id(tokens, ids[0]) || !id(tokens, ids[1])) return;
    if (!numbers(tokens, count + entries, values)) return;
    const double* given = values + count;
    if (count == 3) {
      const double upper[6] = {given[0], given[1], given[4], given[2], given[5], given[3]};
      return check(sink_.add_edge(sink_.host, "EDGE_SE2", 2, ids, 0, nullptr, 3, values, 6, upper,
                                  lines_.lineNumber()));
    }
    double pose[7];
    quaternionPose(values, pose);
    Mat<double, 6> omega;
    for (int r = 0; r < 6; ++r) {
      for (int c = r; c < 6; ++c) omega(r, c) = omega(c, r) = *given++;
    }
    Mat<double, 6> j = Mat<double, 6>::Identity();
    j.bottomRightCorner<3, 3>() =
        eulerByQuaternionVector(Eigen::Quaterniond(pose[6], pose[3], pose[4], pose[5]));
    const Mat<double, 6> chart = j.transpose() * omega * j;
    double upper[21];
    double* next = upper;
    for (int r = 0; r < 6; ++r) {
      for (int c = r; c < 6; ++c) *next++ = 0.5 * (chart(r, c) + chart(c, r));
    }
    check(sink_.add_edge(sink_.host, "EDGE_SE3:QUAT", 2, ids, 0, nullptr, 7, pose, 21, upper,
                         lines_.lineNumber()));
  }

  LineReader lines_;
  const graft_graph_sink& sink_;
  std::string_view name_;
  bool empty_ = true;
  bool good_ = true;
  bool stopped_ = false;
};

}  // namespace

bool looksLikeToro(std::string_view path, std::string_view head) {
  LineReader lines(head);
  std::string_view line;
  while (lines.next(line)) {
    const std::string_view name = LineTokens(line).next();
    if (name.empty()) continue;
    const Tag tag = tagOf(name);
    if (tag == Tag::kVertex2 || tag == Tag::kEdge2) return true;
    constexpr std::string_view kExtension = ".graph";
    const bool named = path.size() >= kExtension.size() &&
                       path.substr(path.size() - kExtension.size()) == kExtension;
    return named && tag != Tag::kOther;
  }
  return false;
}

bool readToro(std::string_view text, const graft_graph_sink& sink) {
  return Reader(text, sink).run();
}

}  // namespace graft::toro
