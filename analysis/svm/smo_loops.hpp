// SPDX-License-Identifier: Apache-2.0
/// The two loops over all points in which sequential minimal optimisation spends its time. They are templates over the
/// size of a register (Registers64, …, in lanes.hpp). The result does not depend on that size.
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "analysis/svm/lanes.hpp"
#include "analysis/svm/smo.hpp"

namespace gyrotherm::svm {

/// Slope that keeps β_i from crossing its bound, and padding from moving.
inline constexpr float kBlockingSlope = 1e30F;

/// Number of lanes that the two loops over all points treat separately. It is the same for each size of register, so
/// all processors choose the same points.
inline constexpr int kSmoLanes = 2 * kFloatLanes;

/// Permutes lanes: lane i of `to` is lane i ^ distance of `from`.
template <int distance, class Lanes>
[[gnu::always_inline]] inline void cross_lanes(const Lanes& from, Lanes& to) {
  [&]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) {
    to = __builtin_shufflevector(from, from, (i ^ distance)...);
  }
  (std::make_integer_sequence<int, sizeof(Lanes) / sizeof(float)>());
}

/// Reduces candidates in all lanes of all `parts` to one in lane 0 of the first part. Candidate::take_better(other,
/// offset) replaces the lanes in which `other` is better; `offset` is added to the other's indices.
template <class Candidate, std::size_t parts>
[[gnu::always_inline]] inline void reduce_lanes(std::array<Candidate, parts>& best) {
  constexpr int kWidth = kSmoLanes / parts;
  for (int half = parts / 2; half > 0; half /= 2)
    for (int part = 0; part < half; ++part) best[part].take_better(best[part + half], half * kWidth);
  const auto fold = [&]<int distance>(std::integral_constant<int, distance>) __attribute__((always_inline)) {
    if constexpr (distance < kWidth) best[0].take_better(best[0].template crossed<distance>(), 0);
  };
  fold(std::integral_constant<int, 8>());
  fold(std::integral_constant<int, 4>());
  fold(std::integral_constant<int, 2>());
  fold(std::integral_constant<int, 1>());
}

/// Sets the lanes to 0, 1, 2, …
template <class Indices>
[[gnu::always_inline]] inline void number_lanes(Indices& lanes) {
  [&]<int... i>(std::integer_sequence<int, i...>) __attribute__((always_inline)) { lanes = Indices{i...}; }
  (std::make_integer_sequence<int, sizeof(Indices) / sizeof(int)>());
}

/// Largest value in each lane, with its index.
template <class Registers>
struct LargestLanes {
  typename Registers::Floats value = typename Registers::Floats{} - kBlockingSlope;
  typename Registers::Indices where = {};

  [[gnu::always_inline]] void take_better(const LargestLanes& other, int offset) {
    const typename Registers::Indices better = other.value > value;
    value = better ? other.value : value;
    where = better ? other.where + offset : where;
  }
  template <int distance>
  [[gnu::always_inline]] [[nodiscard]] LargestLanes crossed() const {
    LargestLanes to;
    cross_lanes<distance>(value, to.value);
    cross_lanes<distance>(where, to.where);
    return to;
  }
};

/// Arrays that each step traverses. `count` is a multiple of 2 · kFloatLanes.
struct SmoLines {
  float* h;
  float* response;
  const float* rise;
  int count;
};

/// Makes the step of a pair with the rows `up` and `down` of K: response = up − down + kept · response, h −= length ·
/// response. Returns the largest u = h − rise of the new h. The structures are passed by value; the compiler then knows
/// that stores to an array do not change them.
template <class Registers>
[[gnu::always_inline]] inline SmoSteepest move_points(SmoLines lines, const float* up, const float* down,
                                                      SmoStep step) {
  using Floats = typename Registers::Floats;
  constexpr int kWidth = sizeof(Floats) / sizeof(float);
  constexpr int kParts = kSmoLanes / kWidth;
  std::array<LargestLanes<Registers>, kParts> best;
  typename Registers::Indices at;
  number_lanes(at);
  for (int i = 0; i < lines.count; i += kSmoLanes) {
    for (int part = 0; part < kParts; ++part) {
      const int k = i + part * kWidth;
      auto& error = lanes_at<Floats>(lines.h + k);
      auto& along = lanes_at<Floats>(lines.response + k);
      const Floats change = lanes_at<Floats>(up + k).value - lanes_at<Floats>(down + k).value + step.kept * along.value;
      along.value = change;
      const Floats changed = error.value - step.length * change;
      error.value = changed;
      best[part].take_better({changed - lanes_at<Floats>(lines.rise + k).value, at}, 0);
    }
    at += kSmoLanes;
  }
  reduce_lanes(best);
  return {.slope = best[0].value[0], .index = best[0].where[0]};
}

/// Candidates compared by their quotients square/curvature without a division, and the least v of each lane.
template <class Registers>
struct PartnerLanes {
  using Floats = typename Registers::Floats;
  Floats square = {};
  Floats curvature = Floats{} + 1.0F;
  typename Registers::Indices where = {};
  Floats least = Floats{} + kBlockingSlope;

  [[gnu::always_inline]] void take_better(const PartnerLanes& other, int offset) {
    const typename Registers::Indices better = other.square * curvature > square * other.curvature;
    square = better ? other.square : square;
    curvature = better ? other.curvature : curvature;
    where = better ? other.where + offset : where;
    least = other.least < least ? other.least : least;
  }
  template <int distance>
  [[gnu::always_inline]] [[nodiscard]] PartnerLanes crossed() const {
    PartnerLanes to;
    cross_lanes<distance>(square, to.square);
    cross_lanes<distance>(curvature, to.curvature);
    cross_lanes<distance>(where, to.where);
    cross_lanes<distance>(least, to.least);
    return to;
  }
};

/// Returns the least v = h − fall, and the j with the largest (u_i − v_j)²/(2 − 2K_ij) among the v_j below `u`. `row`
/// is K_i.
template <class Registers>
[[gnu::always_inline]] inline SmoPartner find_partner(const float* row, const float* h, const float* fall, float u,
                                                      int count) {
  using Floats = typename Registers::Floats;
  constexpr int kWidth = sizeof(Floats) / sizeof(float);
  constexpr int kParts = kSmoLanes / kWidth;
  std::array<PartnerLanes<Registers>, kParts> best;
  typename Registers::Indices at;
  number_lanes(at);
  const Floats highest = Floats{} + u;
  for (int i = 0; i < count; i += kSmoLanes) {
    for (int part = 0; part < kParts; ++part) {
      const int k = i + part * kWidth;
      const Floats v = lanes_at<Floats>(h + k).value - lanes_at<Floats>(fall + k).value;
      const Floats slack = u - (v < highest ? v : highest);
      best[part].take_better({slack * slack, 1.0F - lanes_at<Floats>(row + k).value, at, v}, 0);
    }
    at += kSmoLanes;
  }
  reduce_lanes(best);
  return {.least_slope = best[0].least[0], .index = best[0].where[0]};
}

}  // namespace gyrotherm::svm
