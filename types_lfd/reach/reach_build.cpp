// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <limits>
#include <mutex>
#include <random>
#include <thread>

#include "types_lfd/reach/reach_distance.hpp"
#include "types_lfd/reach/reach_map.hpp"
#include "types_lfd/reach/reach_sampler.hpp"

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kBatch = 4096;
constexpr std::uint64_t kFirstRound = std::uint64_t{1} << 16;
// A voxel counts for any sample in it, so that on average the border runs almost
// half a voxel further in than between voxels. Units of ReachDistance.
constexpr int kInset = 4;
constexpr double kLargestMap = 2147483648.0;

/// SplitMix64: seeds of batches that have nothing to do with each other.
std::uint64_t mixSeed(std::uint64_t seed, std::uint64_t index) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ULL + index + 0x632be59bd9b4e019ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

int cellsFor(double low, double high, double resolution, int& first) {
  first = static_cast<int>(std::floor(low / resolution)) - 1;
  return static_cast<int>(std::ceil(high / resolution)) + 1 - first;
}

ReachGrid checkedGrid(const ReachOptions& options) {
  const auto refuse = [](const std::string& text) {
    throw Error(ExitCode::kUsage, "reachability map: " + text);
  };
  if (!(options.resolution >= 0.005 && options.resolution <= 0.5)) {
    refuse("the resolution has to be 0.005 to 0.5 m");
  }
  const double quarter = 0.5 * kPi / options.angular_step;
  if (!(quarter >= 0.999 && quarter <= 18.001) ||
      std::abs(quarter - std::round(quarter)) > 1e-6 * quarter) {
    refuse("the angular step has to divide a quarter turn, and to be at least 5 degrees");
  }
  if (options.max_samples == 0) refuse("no samples asked for");
  ReachGrid grid;
  grid.turn = 4 * static_cast<int>(std::lround(quarter));
  grid.resolution = options.resolution;
  return grid;
}

/// A grid that holds all that the chain can reach.
ReachGrid makeGrid(const Chain& chain, const ReachOptions& options) {
  ReachGrid grid = checkedGrid(options);
  const Eigen::Vector3d& origin = chain.firstJointOrigin();
  const double reach = chain.reachBound();
  const double around = origin.head<2>().norm() + reach;
  double below = 0;
  double above = 0;
  if (const int torso = chain.heightJoint(); torso >= 0) {
    const double a = chain.heightSign() * chain.lower()[torso];
    const double b = chain.heightSign() * chain.upper()[torso];
    below = std::min(a, b);
    above = std::max(a, b);
  }
  grid.nx = cellsFor(-around, around, grid.resolution, grid.x0);
  grid.ny = grid.nx;
  grid.y0 = grid.x0;
  grid.nz =
      cellsFor(origin[2] - reach + below, origin[2] + reach + above, grid.resolution, grid.z0);
  // Where rolls need no nodes, there is room for more in the other angles.
  grid.rolls = anyRoll(chain) ? 1 : grid.turn;
  grid.fine = grid.rolls == 1 ? 2 : 1;
  // A byte per node, and eight voxels of a bit each.
  if (grid.nx > ReachGrid::kMostNodes || grid.ny > ReachGrid::kMostNodes) {
    throw Error(ExitCode::kResources, "a reachability map at this resolution would be more than " +
                                          std::to_string(ReachGrid::kMostNodes) + " nodes wide");
  }
  const double bytes = 2.0 * static_cast<double>(grid.nodeCount());
  if (bytes > kLargestMap) {
    throw Error(ExitCode::kResources, "a reachability map at this resolution would take " +
                                          std::to_string(static_cast<long>(bytes / 1e6)) +
                                          " MB; the limit is 2147 MB");
  }
  return grid;
}

/// Scale of the quality byte: a little above the best of a few thousand.
double probeManipulability(const Chain& chain, std::uint64_t seed) {
  std::mt19937_64 random(mixSeed(seed, ~std::uint64_t{0}));
  Chain::Jacobian jacobian(6, chain.dof());
  Pose pose;
  double best = 0;
  for (int i = 0; i < 4096; ++i) {
    const Eigen::VectorXd q = sampleJoints(chain, random);
    chain.jacobian(q.data(), pose, jacobian);
    best = std::max(best, manipulability(jacobian));
  }
  return 1.1 * best;
}

}  // namespace

class ReachBuilder {
 public:
  ReachBuilder(const Chain& chain, const ReachOptions& options)
      : chain_(chain),
        options_(options),
        grid_(makeGrid(chain, options)),
        best_(probeManipulability(chain, options.seed)),
        sampler_(chain, grid_, thin(), best_),
        marks_(grid_) {}

  ReachMap run(const ReachProgress& progress) {
    std::uint64_t done = 0;
    std::uint64_t cells = 0;
    double coverage = 0;
    while (done < options_.max_samples) {
      const std::uint64_t target =
          std::min(options_.max_samples, done == 0 ? kFirstRound : 2 * done);
      sampleRound(done, target, progress);
      done = target;
      const std::uint64_t now = marks_.count();
      coverage = now > 0 ? static_cast<double>(cells) / static_cast<double>(now) : 0;
      cells = now;
      if (cells > 0 && 1 - coverage < options_.new_cell_share) break;
    }
    if (progress) progress(1.0);
    return makeMap(done, coverage);
  }

 private:
  /// An arm with less than six freedoms reaches no volume of poses.
  bool thin() const { return chain_.dof() < 6 || best_ <= 1e-9; }

  void sampleRound(std::uint64_t from, std::uint64_t to, const ReachProgress& progress) {
    std::atomic<std::uint64_t> next{from};
    runThreads([&](bool reports) {
      for (;;) {
        const std::uint64_t begin = next.fetch_add(kBatch);
        if (begin >= to) return;
        std::mt19937_64 random(mixSeed(options_.seed, begin));
        sampler_.run(random, std::min(kBatch, to - begin), marks_);
        if (reports && progress) {
          progress(static_cast<double>(begin) / static_cast<double>(options_.max_samples));
        }
      }
    });
  }

  /// work(is this the calling thread) in all threads; the first failure is thrown.
  template <class Work>
  void runThreads(const Work& work) const {
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto guarded = [&](bool first) {
      try {
        work(first);
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex);
        failure = std::current_exception();
      }
    };
    const unsigned all = std::max(1U, std::thread::hardware_concurrency());
    const unsigned count = options_.threads > 0 ? static_cast<unsigned>(options_.threads) : all;
    std::vector<std::thread> helpers;
    for (unsigned i = 1; i < count; ++i) helpers.emplace_back(guarded, false);
    guarded(true);
    for (std::thread& helper : helpers) helper.join();
    if (failure) std::rethrow_exception(failure);
  }

  /// Nodes around what was marked: low and high (x, y, z).
  void findExtent(int* low, int* high) const {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::numeric_limits<int>::max();
      high[k] = -1;
    }
    const int nx = marks_.nx();
    const int ny = marks_.ny();
    const int words = marks_.words();
    const auto include = [&](int axis, int voxel, int nodes) {
      low[axis] = std::min(low[axis], std::max(0, voxel / 2 - 1));
      high[axis] = std::max(high[axis], std::min(nodes - 1, voxel / 2 + 2));
    };
    forEachSlice([&](int ring, int roll, int psi) {
      const auto* column = marks_.slice(ring, roll, psi);
      for (int y = 0; y < ny; ++y) {
        for (int x = 0; x < nx; ++x, column += marks_.stride()) {
          for (int w = 0; w < words; ++w) {
            const std::uint64_t bits = column[w].load(std::memory_order_relaxed);
            if (bits == 0) continue;
            include(0, x, grid_.nx);
            include(1, y, grid_.ny);
            include(2, 64 * w + __builtin_ctzll(bits), grid_.nz);
            include(2, 64 * w + 63 - __builtin_clzll(bits), grid_.nz);
          }
        }
      }
    });
    if (high[0] < 0) {
      throw Error(ExitCode::kNoResult,
                  "no cell of the reachability map was hit; more samples are needed");
    }
  }

  template <class Use>
  void forEachSlice(const Use& use) const {
    for (int ring = 0; ring < grid_.ringCount(); ++ring) {
      for (int roll = 0; roll < grid_.rolls; ++roll) {
        for (int psi = 0; psi < grid_.psiCount(); ++psi) use(ring, roll, psi);
      }
    }
  }

  /// Distances of all orientations, shared out to threads by elevation and roll.
  void fillDistances(const int* low, ReachMap& map) const {
    const ReachGrid& grid = map.grid_;
    map.distances_.assign(grid.nodeCount(), -127);
    std::atomic<int> next{0};
    runThreads([&](bool) {
      // Thin sets are widened, so that all nodes around what is reached are in.
      ReachDistance distance(marks_, thin() ? 2 * ReachDistance::kDistanceUnits : -kInset);
      for (;;) {
        const int task = next++;
        if (task >= grid.ringCount() * grid.rolls) return;
        const int ring = task / grid.rolls;
        const int roll = task % grid.rolls;
        for (int psi = 0; psi < grid.psiCount(); ++psi) {
          const std::int8_t* from = distance.compute(ring, roll, psi).data();
          for (int z = 0; z < grid.nz; ++z) {
            std::int8_t* to = map.distances_.data() + grid.slice(z, ring, roll) * grid.sliceSize() +
                              static_cast<std::size_t>(psi) * grid.layerSize();
            for (int y = 0; y < grid.ny; ++y, to += grid.nx) {
              const int row = ((z + low[2]) * grid_.ny + y + low[1]) * grid_.nx + low[0];
              std::copy_n(from + row, grid.nx, to);
            }
          }
        }
      }
    });
  }

  void fillQualities(const int* low, ReachMap& map) const {
    const ReachGrid& grid = map.grid_;
    map.cells_.assign(grid.cellCount(), 0);
    std::size_t i = 0;
    for (int z = 0; z < grid.nz; ++z) {
      for (int ring = 0; ring < grid.cellRings(); ++ring) {
        for (int psi = 0; psi < grid.turn; ++psi) {
          for (int y = 0; y < grid.ny; ++y) {
            for (int x = 0; x < grid.nx; ++x) {
              map.cells_[i++] =
                  marks_.quality(grid_.cell(z + low[2], ring, psi, y + low[1], x + low[0]));
            }
          }
        }
      }
    }
  }

  /// Cuts the grid to what is reachable.
  ReachMap makeMap(std::uint64_t samples, double coverage) const {
    int low[3];
    int high[3];
    findExtent(low, high);
    ReachMap map;
    ReachGrid& grid = map.grid_;
    grid = grid_;
    grid.x0 += low[0];
    grid.y0 += low[1];
    grid.z0 += low[2];
    grid.nx = high[0] - low[0] + 1;
    grid.ny = high[1] - low[1] + 1;
    grid.nz = high[2] - low[2] + 1;
    fillDistances(low, map);
    fillQualities(low, map);
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
  double best_;
  ReachSampler sampler_;
  ReachMarks marks_;
};

ReachMap ReachMap::build(const Chain& chain, const ReachOptions& options,
                         const ReachProgress& progress) {
  return ReachBuilder(chain, options).run(progress);
}

}  // namespace graft::lfd
