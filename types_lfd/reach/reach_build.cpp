// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <random>
#include <thread>

#include "types_lfd/reach/reach_map.hpp"
#include "types_lfd/reach/reach_sampler.hpp"

namespace graft::lfd {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::uint64_t kBatch = 4096;
constexpr std::uint64_t kFirstRound = std::uint64_t{1} << 16;
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
  if (!(options.core > 0 && options.core <= 1)) refuse("the core has to be above 0, and at most 1");
  if (options.max_samples == 0) refuse("no samples asked for");
  ReachGrid grid;
  grid.turn = 4 * static_cast<int>(std::lround(quarter));
  grid.resolution = options.resolution;
  return grid;
}

/// A grid that holds all that the chain can reach.
ReachGrid makeGrid(const Chain& chain, const ReachOptions& options) {
  ReachGrid grid = checkedGrid(options);
  const Eigen::Vector3d origin = chain.firstJointOrigin();
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
  const double bytes =
      static_cast<double>(grid.sliceSize()) * grid.nz * (grid.ringCount() + 2) * grid.turn;
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
        sampler_(chain, grid_, fillsSpace() ? options.core : 1, best_),
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
  /// Poses of an arm with less than six freedoms are too thin to pass near the
  /// centres of cells: there any pose in a cell has to count.
  bool fillsSpace() const { return chain_.dof() >= 6 && best_ > 1e-9; }

  void sampleRound(std::uint64_t from, std::uint64_t to, const ReachProgress& progress) {
    std::atomic<std::uint64_t> next{from};
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto work = [&](bool reports) {
      try {
        for (;;) {
          const std::uint64_t begin = next.fetch_add(kBatch);
          if (begin >= to) return;
          std::mt19937_64 random(mixSeed(options_.seed, begin));
          sampler_.run(random, std::min(kBatch, to - begin), marks_);
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

  /// Cuts the grid to what is reachable and puts cells in the order of queries.
  ReachMap makeMap(std::uint64_t samples, double coverage) const {
    int low[3] = {grid_.nx, grid_.ny, grid_.nz};
    int high[3] = {-1, -1, -1};
    marks_.forEach([&](int, int, int y, int x, int, int z, std::uint8_t) {
      const int at[3] = {x, y, z};
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], at[k]);
        high[k] = std::max(high[k], at[k]);
      }
    });
    if (high[0] < 0) {
      throw Error(ExitCode::kNoResult,
                  "no cell of the reachability map was hit; more samples are needed");
    }
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
    marks_.forEach([&](int ring, int psi, int y, int x, int roll, int z, std::uint8_t quality) {
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
  double best_;
  ReachSampler sampler_;
  ReachMarks marks_;
};

ReachMap ReachMap::build(const Chain& chain, const ReachOptions& options,
                         const ReachProgress& progress) {
  return ReachBuilder(chain, options).run(progress);
}

}  // namespace graft::lfd
