// SPDX-License-Identifier: Apache-2.0
/// The loops for each size of register, compared with each other and with plain loops over the points.
#include "analysis/svm/smo_loops.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace gyrotherm::svm {
namespace {

/// Random state of `count` points, with padding that never moves.
struct SmoArrays {
  SmoArrays(std::mt19937& generator, int points) {
    const int count = (points + kSmoLanes - 1) / kSmoLanes * kSmoLanes;
    std::uniform_real_distribution<float> number(-1, 1), part(0, 1);
    const auto fill = [&](std::vector<float>& values, float padding) {
      for (int i = 0; i < count; ++i) values.push_back(i < points ? number(generator) : padding);
    };
    fill(h, 0);
    fill(response, 0);
    fill(up, 0);
    fill(down, 0);
    fill(rise, kBlockingSlope);
    fill(fall, -kBlockingSlope);
    for (float& value : up) value = std::abs(value);  // a kernel is at most 1
    for (int i = 0; i < points; ++i)
      if (part(generator) < 0.2F) rise[i] = kBlockingSlope;  // at a bound
  }
  [[nodiscard]] int count() const { return static_cast<int>(h.size()); }
  std::vector<float> h, response, up, down, rise, fall;
};

template <class Registers>
SmoSteepest move_all(SmoArrays& arrays, SmoStep step) {
  return move_points<Registers>({arrays.h.data(), arrays.response.data(), arrays.rise.data(), arrays.count()},
                                arrays.up.data(), arrays.down.data(), step);
}

template <class Registers>
SmoPartner partner_in(const SmoArrays& arrays, float u) {
  return find_partner<Registers>(arrays.up.data(), arrays.h.data(), arrays.fall.data(), u, arrays.count());
}

TEST(SmoLoops, MoveEqualsPlainLoopForEachRegisterSize) {
  std::mt19937 generator(1);
  for (const int points : {1, 2, 31, 32, 33, 64, 500, 1663}) {
    SCOPED_TRACE(points);
    const SmoArrays before(generator, points);
    const SmoStep step{.length = 0.3F, .kept = -0.7F};
    SmoArrays wide = before, half = before, narrow = before;
    const auto a = move_all<Registers64>(wide, step), b = move_all<Registers32>(half, step),
               c = move_all<Registers16>(narrow, step);
    EXPECT_EQ(wide.h, half.h);
    EXPECT_EQ(wide.h, narrow.h);
    EXPECT_EQ(wide.response, half.response);
    EXPECT_EQ(wide.response, narrow.response);
    float largest = -std::numeric_limits<float>::infinity();
    for (int i = 0; i < points; ++i) {
      const float change = before.up[i] - before.down[i] + step.kept * before.response[i];
      EXPECT_NEAR(wide.response[i], change, 1e-6F);
      EXPECT_NEAR(wide.h[i], before.h[i] - step.length * change, 1e-6F);
      largest = std::max(largest, wide.h[i] - wide.rise[i]);
    }
    EXPECT_EQ(a.slope, largest);
    EXPECT_EQ(wide.h[a.index] - wide.rise[a.index], largest);
    for (const SmoSteepest& other : {b, c}) {
      EXPECT_EQ(other.slope, a.slope);
      EXPECT_EQ(other.index, a.index);
    }
  }
}

TEST(SmoLoops, PartnerHasLargestGainForEachRegisterSize) {
  std::mt19937 generator(2);
  for (const int points : {2, 31, 32, 33, 64, 500, 1663}) {
    SCOPED_TRACE(points);
    const SmoArrays arrays(generator, points);
    constexpr float kSteepest = 1.5F;
    const auto a = partner_in<Registers64>(arrays, kSteepest), b = partner_in<Registers32>(arrays, kSteepest),
               c = partner_in<Registers16>(arrays, kSteepest);
    double best = 0;
    float least = std::numeric_limits<float>::infinity();
    const auto gain = [&](int i) {
      const double slack = std::max(0.0, double{kSteepest} - (double{arrays.h[i]} - arrays.fall[i]));
      return slack * slack / (1 - double{arrays.up[i]});
    };
    for (int i = 0; i < points; ++i) {
      best = std::max(best, gain(i));
      least = std::min(least, arrays.h[i] - arrays.fall[i]);
    }
    EXPECT_EQ(a.least_slope, least);
    EXPECT_NEAR(gain(a.index), best, 1e-5 * best);
    for (const SmoPartner& other : {b, c}) {
      EXPECT_EQ(other.least_slope, a.least_slope);
      EXPECT_EQ(other.index, a.index);
    }
  }
}

/// Equal points occur in real records: all sizes must choose the same one.
TEST(SmoLoops, ChooseSamePointAmongEqualOnes) {
  std::mt19937 generator(3);
  std::uniform_int_distribution<int> level(0, 2);
  for (int trial = 0; trial < 200; ++trial) {
    SmoArrays arrays(generator, 96);
    for (auto* values : {&arrays.h, &arrays.up})
      for (float& value : *values) value = 0.25F * static_cast<float>(level(generator));
    std::ranges::fill(arrays.fall, 0.0F);
    std::ranges::fill(arrays.rise, 0.0F);
    const auto partner = partner_in<Registers64>(arrays, 1);
    EXPECT_EQ(partner_in<Registers32>(arrays, 1).index, partner.index);
    EXPECT_EQ(partner_in<Registers16>(arrays, 1).index, partner.index);
    SmoArrays half = arrays, narrow = arrays;
    const auto moved = move_all<Registers64>(arrays, {.length = 0.5F, .kept = 0});
    EXPECT_EQ(move_all<Registers32>(half, {.length = 0.5F, .kept = 0}).index, moved.index);
    EXPECT_EQ(move_all<Registers16>(narrow, {.length = 0.5F, .kept = 0}).index, moved.index);
  }
}

TEST(SmoLoops, ReportNoGainIfNoPointIsBelow) {
  std::mt19937 generator(4);
  const SmoArrays arrays(generator, 40);
  const float u = -5;
  for (const SmoPartner& partner :
       {partner_in<Registers64>(arrays, u), partner_in<Registers32>(arrays, u), partner_in<Registers16>(arrays, u)}) {
    EXPECT_GT(partner.least_slope, u);
    EXPECT_GE(partner.index, 0);
    EXPECT_LT(partner.index, arrays.count());
  }
}

}  // namespace
}  // namespace gyrotherm::svm
