// SPDX-License-Identifier: BSD-3-Clause
#include "apps/graft/simulated_world.hpp"

#include <array>
#include <cmath>
#include <map>

namespace graft {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// A pose at a place, x axis towards the next place, z axis roughly along `up`.
Pose facing(const Vec<double, 3>& place, const Vec<double, 3>& next, const Vec<double, 3>& up) {
  const Vec<double, 3> x = (next - place).normalized();
  const Vec<double, 3> y = up.cross(x).normalized();
  Mat<double, 3> axes;
  axes << x, y, x.cross(y);
  return Pose(place, Eigen::Quaterniond(axes).normalized());
}

/// Rings of places on a surface of revolution; `place` maps (ring, angle).
template <class Place, class Normal>
SimulatedWorld rings(int size, bool closed, const Place& place, const Normal& normal) {
  SimulatedWorld world;
  const int count = size * size;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * kPi * (i % size) / size;
    const double ring = double(i) / size;
    const double next_ring = double(i + 1) / size;
    world.space.push_back(
        facing(place(ring, angle), place(next_ring, angle + 2 * kPi / size), normal(ring, angle)));
    if (i + 1 < count) world.edges.emplace_back(i, i + 1);
    if (i + size < count) {
      world.edges.emplace_back(i, i + size);
    } else if (closed) {
      world.edges.emplace_back(i, i + size - count);
    }
  }
  return world;
}

}  // namespace

double NormalDeviates::next() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  // Marsaglia's polar method on 53-bit fractions.
  const auto uniform = [this] { return double(random_() >> 11) * 0x1p-52 - 1.0; };
  double u = 0;
  double v = 0;
  double s = 0;
  do {
    u = uniform();
    v = uniform();
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  const double factor = std::sqrt(-2 * std::log(s) / s);
  spare_ = v * factor;
  has_spare_ = true;
  return u * factor;
}

SimulatedWorld sphereWorld(int size) {
  const double radius = size / kPi;
  const auto direction = [size](double ring, double angle) {
    // From near one pole to near the other, along a spiral.
    const double polar = kPi * (ring + 0.5) / (size + 1);
    return Vec<double, 3>(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle),
                          -std::cos(polar));
  };
  return rings(
      size, false,
      [&](double ring, double angle) { return Vec<double, 3>(radius * direction(ring, angle)); },
      direction);
}

SimulatedWorld torusWorld(int size) {
  const double small = size / (2 * kPi);
  const double large = 2 * small;
  const auto normal = [size](double ring, double angle) {
    const double around = 2 * kPi * ring / size;
    return Vec<double, 3>(std::cos(angle) * std::cos(around), std::cos(angle) * std::sin(around),
                          std::sin(angle));
  };
  return rings(
      size, true,
      [&, size](double ring, double angle) {
        const double around = 2 * kPi * ring / size;
        return Vec<double, 3>(large * Vec<double, 3>(std::cos(around), std::sin(around), 0) +
                              small * normal(ring, angle));
      },
      normal);
}

SimulatedWorld gridWorld(int size) {
  SimulatedWorld world;
  std::map<std::array<int, 3>, int> at;
  for (int k = 0; k < size; ++k) {
    for (int row = 0; row < size; ++row) {
      for (int column = 0; column < size; ++column) {
        // Back and forth, so that successive poses are neighbours.
        const int j = k % 2 == 0 ? row : size - 1 - row;
        const bool forth = (k * size + row) % 2 == 0;
        const int i = forth ? column : size - 1 - column;
        const int now = int(world.space.size());
        const double heading = forth ? 0 : kPi;
        world.space.emplace_back(Vec<double, 3>(i, j, k),
                                 expSO3<double>(Vec<double, 3>(0, 0, heading)));
        if (now > 0) world.edges.emplace_back(now - 1, now);
        for (const std::array<int, 3>& past :
             {std::array<int, 3>{i - 1, j, k}, std::array<int, 3>{i + 1, j, k},
              std::array<int, 3>{i, j - 1, k}, std::array<int, 3>{i, j + 1, k},
              std::array<int, 3>{i, j, k - 1}}) {
          const auto position = at.find(past);
          if (position != at.end() && position->second < now - 1) {
            world.edges.emplace_back(position->second, now);
          }
        }
        at[{i, j, k}] = now;
      }
    }
  }
  return world;
}

SimulatedWorld manhattanWorld(int size, NormalDeviates& random) {
  SimulatedWorld world;
  std::map<std::array<int, 2>, int> at;
  constexpr int kStep[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  // A town of this many blocks is crossed often enough to close loops.
  const int limit = std::max(4, int(std::sqrt(size) / 2));
  int x = 0;
  int y = 0;
  int heading = 0;
  for (int i = 0; i < size; ++i) {
    world.plane.emplace_back(x, y, wrapAngle(heading * kPi / 2));
    if (i > 0) world.edges.emplace_back(i - 1, i);
    for (const std::array<int, 2>& crossing :
         {std::array<int, 2>{x, y}, std::array<int, 2>{x + 1, y}, std::array<int, 2>{x, y + 1}}) {
      const auto past = at.find(crossing);
      if (past != at.end() && past->second < i - 3) world.edges.emplace_back(past->second, i);
    }
    at[{x, y}] = i;
    if (random.below(4) == 0) heading = (heading + (random.below(2) == 0 ? 1 : 3)) % 4;
    while (std::abs(x + kStep[heading][0]) > limit || std::abs(y + kStep[heading][1]) > limit) {
      heading = (heading + 1) % 4;
    }
    x += kStep[heading][0];
    y += kStep[heading][1];
  }
  return world;
}

}  // namespace graft
