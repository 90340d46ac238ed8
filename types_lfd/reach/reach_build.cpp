// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <random>
#include <thread>

#include "types_lfd/reach/reach_map.hpp"

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kBatch = 4096;
constexpr std::uint64_t kFirstRound = std::uint64_t{1} << 18;
constexpr std::size_t kLargestMap = std::size_t{1} << 31;

/// Yoshikawa's manipulability: the product of the Jacobian's singular values.
double manipulability(const Chain::Jacobian& jacobian) {
  if (jacobian.cols() >= 6) {
    const Eigen::Matrix<double, 6, 6> gram = jacobian.lazyProduct(jacobian.transpose());
    return std::sqrt(std::max(0.0, gram.determinant()));
  }
  const Eigen::MatrixXd gram = jacobian.transpose() * jacobian;
  return std::sqrt(std::max(0.0, gram.determinant()));
}

/// SplitMix64: seeds of batches that have nothing to do with each other.
std::uint64_t mixSeed(std::uint64_t seed, std::uint64_t index) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ULL + index + 0x632be59bd9b4e019ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

int cellsFor(double low, double high, double resolution, int& first) {
  first = static_cast<int>(std::floor(low / resolution)) - 1;
  return static_cast<int>(std::ceil(high / resolution)) + 1 - first;
}

}  // namespace

/// Fills a working copy of the map in which height is fastest, then roll, since
/// one sample marks a range of both: a torso joint moves the gripper straight
/// up without changing anything else, and a last joint along the approach axis
/// changes the roll alone. Marking takes the maximum, so that threads may come
/// in any order.
class ReachBuilder {
 public:
  ReachBuilder(const Chain& chain, const ReachOptions& options) : chain_(chain), options_(options) {
    checkOptions();
    makeGrid();
    probeManipulability();
    marks_ = std::vector<std::atomic<std::uint8_t>>(columnCount() * columnSize());
  }

  ReachMap run(const ReachProgress& progress) {
    std::uint64_t done = 0;
    std::uint64_t cells = 0;
    double coverage = 0;
    while (done < options_.max_samples) {
      const std::uint64_t target =
          std::min(options_.max_samples, done == 0 ? kFirstRound : 2 * done);
      sampleRound(done, target, progress);
      done = target;
      const std::uint64_t now = countMarks();
      coverage = now > 0 ? static_cast<double>(cells) / static_cast<double>(now) : 0;
      cells = now;
      if (1 - coverage < options_.new_cell_share) break;
    }
    if (progress) progress(1.0);
    return makeMap(done, coverage);
  }

 private:
  void checkOptions() {
    const auto refuse = [](const std::string& text) {
      throw Error(ExitCode::kUsage, "reachability map: " + text);
    };
    if (!(options_.resolution >= 0.005 && options_.resolution <= 0.5)) {
      refuse("the resolution has to be 0.005 to 0.5 m");
    }
    const double quarter = 0.5 * kPi / options_.angular_step;
    if (!(quarter >= 0.999 && quarter <= 18.001) ||
        std::abs(quarter - std::round(quarter)) > 1e-6 * quarter) {
      refuse("the angular step has to divide a quarter turn, and to be at least 5 degrees");
    }
    if (options_.max_samples == 0) refuse("no samples asked for");
    grid_.turn = 4 * static_cast<int>(std::lround(quarter));
    grid_.resolution = options_.resolution;
  }

  void makeGrid() {
    const Eigen::Vector3d origin = chain_.firstJointOrigin();
    const double reach = chain_.reachBound();
    const double around = origin.head<2>().norm() + reach;
    double below = 0;
    double above = 0;
    if (const int torso = chain_.heightJoint(); torso >= 0) {
      const double a = chain_.heightSign() * chain_.lower()[torso];
      const double b = chain_.heightSign() * chain_.upper()[torso];
      below = std::min(a, b);
      above = std::max(a, b);
    }
    grid_.nx = cellsFor(-around, around, grid_.resolution, grid_.x0);
    grid_.ny = grid_.nx;
    grid_.y0 = grid_.x0;
    grid_.nz =
        cellsFor(origin[2] - reach + below, origin[2] + reach + above, grid_.resolution, grid_.z0);
    const double bytes =
        static_cast<double>(grid_.sliceSize()) * grid_.nz * (grid_.ringCount() + 2) * grid_.turn;
    if (bytes > static_cast<double>(kLargestMap)) {
      throw Error(ExitCode::kResources, "a reachability map at this resolution would take " +
                                            std::to_string(static_cast<long>(bytes / 1e6)) +
                                            " MB; the limit is 2147 MB");
    }
  }

  /// Scale of the quality byte: a little above the best of a few thousand.
  void probeManipulability() {
    std::mt19937_64 random(mixSeed(options_.seed, ~std::uint64_t{0}));
    Chain::Jacobian jacobian(6, chain_.dof());
    Pose pose;
    for (int i = 0; i < 4096; ++i) {
      const Eigen::VectorXd q = sampleJoints(chain_, random);
      chain_.jacobian(q.data(), pose, jacobian);
      best_ = std::max(best_, manipulability(jacobian));
    }
    best_ *= 1.1;
  }

  // A column holds all (roll, height) of one (ring or cap, psi, y, x).
  std::size_t columnSize() const {
    return static_cast<std::size_t>(grid_.turn) * static_cast<std::size_t>(grid_.nz);
  }
  std::size_t columnCount() const {
    return static_cast<std::size_t>(grid_.ringCount() + 2) * grid_.sliceSize();
  }

  void sampleRound(std::uint64_t from, std::uint64_t to, const ReachProgress& progress) {
    std::atomic<std::uint64_t> next{from};
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto work = [&](bool reports) {
      try {
        for (;;) {
          const std::uint64_t begin = next.fetch_add(kBatch);
          if (begin >= to) return;
          sampleBatch(begin, std::min(begin + kBatch, to));
          if (reports && progress) {
            progress(static_cast<double>(begin) / static_cast<double>(options_.max_samples));
          }
        }
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex);
        failure = std::current_exception();
        next = to;
      }
    };
    const unsigned all = std::max(1U, std::thread::hardware_concurrency());
    const unsigned count = options_.threads > 0 ? static_cast<unsigned>(options_.threads) : all;
    std::vector<std::thread> helpers;
    for (unsigned i = 1; i < count; ++i) helpers.emplace_back(work, false);
    work(true);
    for (std::thread& helper : helpers) helper.join();
    if (failure) std::rethrow_exception(failure);
  }

  void sampleBatch(std::uint64_t begin, std::uint64_t end) {
    std::mt19937_64 random(mixSeed(options_.seed, begin));
    Chain::Jacobian jacobian(6, chain_.dof());
    Eigen::VectorXd q(chain_.dof());
    Pose pose;
    const int torso = chain_.heightJoint();
    const int last = chain_.dof() - 1;
    for (std::uint64_t i = begin; i < end; ++i) {
      for (int j = 0; j <= last; ++j) {
        q[j] = chain_.lower()[j] + uniform(random) * (chain_.upper()[j] - chain_.lower()[j]);
      }
      if (torso >= 0) q[torso] = 0;
      if (chain_.lastJointRolls()) q[last] = 0;
      chain_.jacobian(q.data(), pose, jacobian);
      const double w = best_ > 0 ? manipulability(jacobian) / best_ : 0;
      const auto quality = static_cast<std::uint8_t>(1 + std::min(254.0, std::floor(255 * w)));
      markRolls(pose, quality, random);
    }
  }

  /// All rolls that the last joint gives, where it does.
  void markRolls(const Pose& base_T_gripper, std::uint8_t quality, std::mt19937_64& random) {
    const Eigen::Matrix3d r = base_T_gripper.rotation.toRotationMatrix();
    const int ring = grid_.ring(r(2, 0));
    const int cap = grid_.turn / 4;
    if (!chain_.lastJointRolls()) {
      mark(r, base_T_gripper.translation, ring, quality);
      return;
    }
    const int last = chain_.dof() - 1;
    const double low = chain_.lower()[last];
    const double range = chain_.upper()[last] - low;
    if (std::abs(ring) >= cap) {
      // Here roll turns the heading, and with it the base around the gripper.
      const int strata = 2 * grid_.turn;
      for (int k = 0; k < strata; ++k) {
        const double q = low + range * (k + uniform(random)) / strata;
        const Eigen::Matrix3d turned =
            r *
            Eigen::AngleAxisd(chain_.rollSign() * q, Eigen::Vector3d::UnitX()).toRotationMatrix();
        mark(turned, base_T_gripper.translation, ring, quality);
      }
      return;
    }
    const GripperView view = grid_.view(r, base_T_gripper.translation);
    const double azimuth = view.heading;
    const double roll = std::atan2(std::sin(azimuth) * r(0, 2) - std::cos(azimuth) * r(1, 2),
                                   std::cos(azimuth) * r(1, 1) - std::sin(azimuth) * r(0, 1));
    const double a = roll + chain_.rollSign() * low;
    const double b = roll + chain_.rollSign() * (low + range);
    const int first = static_cast<int>(std::floor(std::min(a, b) / grid_.step() + 0.5));
    const int count = std::min(
        grid_.turn - 1, static_cast<int>(std::floor(std::max(a, b) / grid_.step() + 0.5)) - first);
    for (int k = 0; k <= count; ++k) {
      const int bin = ((first + k) % grid_.turn + grid_.turn) % grid_.turn;
      markHeights(view, ring, bin, quality);
    }
  }

  void mark(const Eigen::Matrix3d& r, const Eigen::Vector3d& position, int ring,
            std::uint8_t quality) {
    const GripperView view = grid_.view(r, position);
    const bool in_cap = view.tilt >= grid_.ringCount() * grid_.turn;
    markHeights(view, ring, in_cap ? 0 : view.tilt % grid_.turn, quality);
  }

  /// The base stands at the origin of the samples' frame. Marks all heights
  /// that the torso gives.
  void markHeights(const GripperView& view, int ring, int roll_bin, std::uint8_t quality) {
    const Pose2 base = baseInView(view, Pose2());
    const int x = static_cast<int>(std::floor(base.x / grid_.resolution)) - grid_.x0;
    const int y = static_cast<int>(std::floor(base.y / grid_.resolution)) - grid_.y0;
    if (x < 0 || y < 0 || x >= grid_.nx || y >= grid_.ny) return;
    double low = view.position[2];
    double high = low;
    if (const int torso = chain_.heightJoint(); torso >= 0) {
      const double a = chain_.heightSign() * chain_.lower()[torso];
      const double b = chain_.heightSign() * chain_.upper()[torso];
      low += std::min(a, b);
      high += std::max(a, b);
    }
    const int z_first = std::max(0, grid_.heightBin(low));
    const int z_last = std::min(grid_.nz - 1, grid_.heightBin(high));
    const int ring_index = std::clamp(ring + grid_.turn / 4, 0, grid_.ringCount() + 1);
    const std::size_t column =
        columnIndex(ring_index, grid_.angleBin(base.theta), y, x) * columnSize() +
        static_cast<std::size_t>(roll_bin) * static_cast<std::size_t>(grid_.nz);
    for (int z = z_first; z <= z_last; ++z) raise(column + static_cast<std::size_t>(z), quality);
  }

  std::size_t columnIndex(int ring_index, int psi, int y, int x) const {
    const auto row = (static_cast<std::size_t>(ring_index) * static_cast<std::size_t>(grid_.turn) +
                      static_cast<std::size_t>(psi)) *
                         static_cast<std::size_t>(grid_.ny) +
                     static_cast<std::size_t>(y);
    return row * static_cast<std::size_t>(grid_.nx) + static_cast<std::size_t>(x);
  }

  void raise(std::size_t index, std::uint8_t quality) {
    std::atomic<std::uint8_t>& cell = marks_[index];
    std::uint8_t old = cell.load(std::memory_order_relaxed);
    while (old < quality && !cell.compare_exchange_weak(old, quality, std::memory_order_relaxed)) {
    }
  }

  std::uint64_t countMarks() const {
    return static_cast<std::uint64_t>(
        std::count_if(marks_.begin(), marks_.end(),
                      [](const auto& m) { return m.load(std::memory_order_relaxed) != 0; }));
  }

  template <class Use>
  void forEachMark(const Use& use) const {
    std::size_t index = 0;
    for (int ring = 0; ring < grid_.ringCount() + 2; ++ring) {
      for (int psi = 0; psi < grid_.turn; ++psi) {
        for (int y = 0; y < grid_.ny; ++y) {
          for (int x = 0; x < grid_.nx; ++x) {
            for (int roll = 0; roll < grid_.turn; ++roll) {
              for (int z = 0; z < grid_.nz; ++z, ++index) {
                const std::uint8_t quality = marks_[index].load(std::memory_order_relaxed);
                if (quality != 0) use(ring - grid_.turn / 4, psi, y, x, roll, z, quality);
              }
            }
          }
        }
      }
    }
  }

  /// Cuts the grid to what is reachable and puts cells in the order of queries.
  ReachMap makeMap(std::uint64_t samples, double coverage) const {
    int low[3] = {grid_.nx, grid_.ny, grid_.nz};
    int high[3] = {-1, -1, -1};
    forEachMark([&](int, int, int y, int x, int, int z, std::uint8_t) {
      const int at[3] = {x, y, z};
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], at[k]);
        high[k] = std::max(high[k], at[k]);
      }
    });
    ReachMap map;
    ReachGrid& grid = map.grid_;
    grid = grid_;
    grid.x0 += low[0];
    grid.y0 += low[1];
    grid.z0 += low[2];
    grid.nx = high[0] - low[0] + 1;
    grid.ny = high[1] - low[1] + 1;
    grid.nz = high[2] - low[2] + 1;
    map.cells_.assign(grid.cellCount(), 0);
    forEachMark([&](int ring, int psi, int y, int x, int roll, int z, std::uint8_t quality) {
      const std::size_t slice = grid.slice(z - low[2], grid.tiltOf(ring, roll));
      const auto row = static_cast<std::size_t>(psi) * static_cast<std::size_t>(grid.ny) +
                       static_cast<std::size_t>(y - low[1]);
      map.cells_[slice * grid.sliceSize() + row * static_cast<std::size_t>(grid.nx) +
                 static_cast<std::size_t>(x - low[0])] = quality;
    });
    map.robot_ = chain_.robotName();
    map.base_link_ = chain_.baseLink();
    map.tip_link_ = chain_.tipLink();
    map.chain_hash_ = chain_.hash();
    map.seed_ = options_.seed;
    map.samples_ = samples;
    map.coverage_ = coverage;
    map.best_manipulability_ = best_;
    map.finish();
    return map;
  }

  const Chain& chain_;
  ReachOptions options_;
  ReachGrid grid_;
  double best_ = 0;
  std::vector<std::atomic<std::uint8_t>> marks_;
};

ReachMap ReachMap::build(const Chain& chain, const ReachOptions& options,
                         const ReachProgress& progress) {
  return ReachBuilder(chain, options).run(progress);
}

}  // namespace graft::lfd
