// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/hex20.hpp"

#include <gtest/gtest.h>

#include <random>

namespace gyrotherm::thermal {
namespace {

TEST(Hex20, IsOneAtOwnNodeAndZeroAtOthers) {
  for (int n = 0; n < kHex20; ++n) {
    const auto& p = kHex20Positions[n];
    const auto shape = hex20_shape(p[0] - 1, p[1] - 1, p[2] - 1);
    for (int m = 0; m < kHex20; ++m) EXPECT_NEAR(shape[m], n == m ? 1 : 0, 1e-15) << n << ' ' << m;
  }
}

TEST(Hex20, RepresentsEveryQuadratic) {
  const auto f = [](double x, double y, double z) {
    return 1 - 2 * x + 3 * y + z + x * x - 0.5 * y * y + 2 * z * z + x * y - 3 * y * z + 0.7 * x * z;
  };
  Hex20Vector values;
  for (int n = 0; n < kHex20; ++n)
    values[n] = f(kHex20Positions[n][0] - 1, kHex20Positions[n][1] - 1, kHex20Positions[n][2] - 1);
  for (unsigned seed = 1; seed <= 100; ++seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> place(-1, 1);
    const double x = place(engine);
    const double y = place(engine);
    const double z = place(engine);
    EXPECT_NEAR(hex20_shape(x, y, z).dot(values), f(x, y, z), 1e-12) << "seed " << seed;
    const Eigen::Vector3d slope = hex20_slopes(x, y, z) * values;
    EXPECT_NEAR(slope[0], -2 + 2 * x + y + 0.7 * z, 1e-12) << "seed " << seed;
    EXPECT_NEAR(slope[1], 3 - y + x - 3 * z, 1e-12) << "seed " << seed;
    EXPECT_NEAR(slope[2], 1 + 4 * z - 3 * y + 0.7 * x, 1e-12) << "seed " << seed;
  }
}

TEST(Hex20, IntegratesToVolumesAndAreas) {
  const auto& r = hex20_integrals();
  EXPECT_NEAR(r.load.sum(), 8, 1e-12);
  EXPECT_NEAR(r.mass.sum(), 8, 1e-12);
  for (int face = 0; face < 6; ++face) {
    EXPECT_NEAR(r.face_load[face].sum(), 4, 1e-12);
    EXPECT_NEAR(r.face_mass[face].sum(), 4, 1e-12);
  }
  for (const auto& slopes : r.slopes) EXPECT_NEAR((slopes * Hex20Vector::Ones()).norm(), 0, 1e-12);
  EXPECT_NEAR((r.cross * Hex20Vector::Ones()).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace gyrotherm::thermal
