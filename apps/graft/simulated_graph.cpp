// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/simulated_graph.hpp"

#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/geometry/se2.hpp"
#include "core/geometry/se3.hpp"

namespace graft {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Normal deviates by Box and Muller, so that the library does not matter.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : random_(seed) {}
  double uniform() { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * kPi * uniform());
  }
  int below(int n) { return static_cast<int>(uniform() * n); }

 private:
  std::mt19937_64 random_;
};

struct Link {
  int from;
  int to;
};

void appendNumbers(std::string& out, const double* numbers, int count) {
  for (int i = 0; i < count; ++i) {
    out += ' ';
    appendDouble(out, numbers[i]);
  }
}

/// Upper triangle of a diagonal matrix.
void appendDiagonal(std::string& out, const std::vector<double>& diagonal) {
  for (std::size_t r = 0; r < diagonal.size(); ++r) {
    for (std::size_t c = r; c < diagonal.size(); ++c) {
      out += ' ';
      appendDouble(out, r == c ? diagonal[r] : 0);
    }
  }
}

/// The two spaces differ in names, noise and information only.
struct Space3 {
  using PoseType = Pose;
  static constexpr const char* kVertex = "VERTEX_SE3:QUAT";
  static constexpr const char* kEdge = "EDGE_SE3:QUAT";
  static Pose disturbed(const Pose& exact, const SimulationOptions& o, Noise& noise) {
    Vec<double, 6> d;
    for (int i = 0; i < 6; ++i) d[i] = (i < 3 ? o.sigma_t : o.sigma_r) * noise.normal();
    return exact.plus(d);
  }
  static std::vector<double> information(const SimulationOptions& o) {
    // The error of this edge type counts half angles.
    const double t = 1 / (o.sigma_t * o.sigma_t);
    const double r = 4 / (o.sigma_r * o.sigma_r);
    return {t, t, t, r, r, r};
  }
};
struct Space2 {
  using PoseType = Pose2;
  static constexpr const char* kVertex = "VERTEX_SE2";
  static constexpr const char* kEdge = "EDGE_SE2";
  static Pose2 disturbed(const Pose2& exact, const SimulationOptions& o, Noise& noise) {
    return exact.plus(Vec<double, 3>(o.sigma_t * noise.normal(), o.sigma_t * noise.normal(),
                                     o.sigma_r * noise.normal()));
  }
  static std::vector<double> information(const SimulationOptions& o) {
    const double t = 1 / (o.sigma_t * o.sigma_t);
    return {t, t, 1 / (o.sigma_r * o.sigma_r)};
  }
};

template <class Space>
std::string format(const std::vector<typename Space::PoseType>& truth,
                   const std::vector<Link>& links, const SimulationOptions& options, Noise& noise) {
  using PoseType = typename Space::PoseType;
  std::vector<PoseType> start(truth.size());
  std::string edges;
  if (!truth.empty()) start[0] = truth[0];
  for (const Link& link : links) {
    const auto from = static_cast<std::size_t>(link.from);
    const auto to = static_cast<std::size_t>(link.to);
    const PoseType measured = Space::disturbed(truth[from].inverse() * truth[to], options, noise);
    // Dead reckoning: every pose follows from the one before.
    if (link.to == link.from + 1) start[to] = start[from] * measured;
    double numbers[PoseType::kAmbientDim];
    measured.toArray(numbers);
    edges +=
        std::string(Space::kEdge) + ' ' + std::to_string(link.from) + ' ' + std::to_string(link.to);
    appendNumbers(edges, numbers, PoseType::kAmbientDim);
    appendDiagonal(edges, Space::information(options));
    edges += '\n';
  }
  std::string out;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    PoseType pose = options.truth ? truth[i] : start[i];
    pose.renormalize();
    double numbers[PoseType::kAmbientDim];
    pose.toArray(numbers);
    out += std::string(Space::kVertex) + ' ' + std::to_string(i);
    appendNumbers(out, numbers, PoseType::kAmbientDim);
    out += '\n';
  }
  return out + edges;
}

/// A pose at a point that looks along `forward`, as upright as that allows.
Pose looking(const Vec<double, 3>& point, const Vec<double, 3>& forward) {
  const double yaw = std::atan2(forward[1], forward[0]);
  const double pitch = -std::asin(std::max(-1.0, std::min(1.0, forward[2] / forward.norm())));
  return Pose(point, expSO3<double>(Vec<double, 3>(0, 0, yaw)) *
                         expSO3<double>(Vec<double, 3>(0, pitch, 0)));
}

/// Rings of poses; each sees its neighbour on the next ring.
std::string simulateRings(const SimulationOptions& options, bool torus, Noise& noise) {
  const int n = options.size;
  std::vector<Pose> truth;
  const auto point = [&](int ring, int step) -> Vec<double, 3> {
    const double around = 2 * kPi * step / n;
    const double along = (ring + static_cast<double>(step) / n) / n;
    if (torus) {
      const double big = 2 * kPi * along;
      const double radius = 10 + 3 * std::cos(around);
      return {radius * std::cos(big), radius * std::sin(big), 3 * std::sin(around)};
    }
    const double height = kPi * (0.05 + 0.9 * along);
    return {10 * std::sin(height) * std::cos(around), 10 * std::sin(height) * std::sin(around),
            10 * std::cos(height)};
  };
  std::vector<Link> links;
  for (int ring = 0; ring < n; ++ring) {
    for (int step = 0; step < n; ++step) {
      const Vec<double, 3> here = point(ring, step);
      const Vec<double, 3> next = step + 1 < n ? point(ring, step + 1) : point(ring + 1, 0);
      truth.push_back(looking(here, next - here));
      const int id = ring * n + step;
      if (id > 0) links.push_back({id - 1, id});
      if (ring > 0) links.push_back({id - n, id});
    }
  }
  for (int step = 0; torus && step < n; ++step) links.push_back({(n - 1) * n + step, step});
  return format<Space3>(truth, links, options, noise);
}

std::string simulateGrid(const SimulationOptions& options, Noise& noise) {
  const int n = options.size;
  const int layers = std::max(1, n / 5);
  std::vector<Pose> truth;
  std::vector<Link> links;
  std::map<std::vector<int>, int> at;
  for (int z = 0; z < layers; ++z) {
    for (int row = 0; row < n; ++row) {
      for (int k = 0; k < n; ++k) {
        // Snake order, so that consecutive poses are neighbours.
        const int y = z % 2 == 0 ? row : n - 1 - row;
        const int x = (row + z * n) % 2 == 0 ? k : n - 1 - k;
        const int id = static_cast<int>(truth.size());
        truth.push_back(Pose(Vec<double, 3>(x, y, z),
                             expSO3<double>(Vec<double, 3>(0, 0, 0.5 * kPi * noise.below(4)))));
        at[{x, y, z}] = id;
        if (id > 0) links.push_back({id - 1, id});
        for (const std::vector<int>& other : {std::vector<int>{x - 1, y, z},
                                              {x + 1, y, z},
                                              {x, y - 1, z},
                                              {x, y + 1, z},
                                              {x, y, z - 1}}) {
          const auto found = at.find(other);
          if (found != at.end() && found->second < id - 1) links.push_back({found->second, id});
        }
      }
    }
  }
  return format<Space3>(truth, links, options, noise);
}

std::string simulateManhattan(const SimulationOptions& options, Noise& noise) {
  std::vector<Pose2> truth{Pose2(0, 0, 0)};
  std::vector<Link> links;
  std::map<std::pair<int, int>, int> last_at{{{0, 0}, 0}};
  const int steps = 100 * options.size;
  for (int i = 1; i < steps; ++i) {
    const int turn = noise.below(6);  // mostly straight on
    const double heading = turn == 0 ? 0.5 * kPi : turn == 1 ? -0.5 * kPi : 0;
    truth.push_back(truth.back() * Pose2(1, 0, heading));
    truth.back().theta = wrapAngle(truth.back().theta);
    links.push_back({i - 1, i});
    const std::pair<int, int> place(static_cast<int>(std::lround(truth.back().x)),
                                    static_cast<int>(std::lround(truth.back().y)));
    const auto [found, is_new] = last_at.insert({place, i});
    if (!is_new) {
      if (found->second < i - 10) links.push_back({found->second, i});
      found->second = i;
    }
  }
  return format<Space2>(truth, links, options, noise);
}

}  // namespace

std::string simulateGraph(const SimulationOptions& options) {
  if (!(options.sigma_t > 0 && options.sigma_r > 0 && options.sigma_t < 1e6 &&
        options.sigma_r < 1e6)) {
    throw Error(ExitCode::kUsage, "the noise must be positive");
  }
  Noise noise(options.seed);
  if (options.kind == "sphere") return simulateRings(options, false, noise);
  if (options.kind == "torus") return simulateRings(options, true, noise);
  if (options.kind == "grid") return simulateGrid(options, noise);
  if (options.kind == "manhattan") return simulateManhattan(options, noise);
  throw Error(ExitCode::kUsage, "unknown shape " + quoted(options.kind) +
                                    ", known are sphere, torus, grid and manhattan");
}

}  // namespace graft
