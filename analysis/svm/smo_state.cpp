#include "analysis/svm/smo_state.hpp"

#include <array>
#include <limits>

#include "analysis/svm/gaussian_samples.hpp"
#include "analysis/svm/lanes.hpp"

namespace gyrotherm {
namespace {

// Stands for a slope that no step may climb: β_i is at its bound, or i is padding.
constexpr float kWall = 1e30F;
constexpr float kLeastCurvature = 1e-12F;
// Of the pair's own curvature, for a direction conjugate to the last.
constexpr double kLeastShare = 1e-3;
constexpr IndexLanes kCount = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

// Lanes moved by half, a quarter, … of their number, for reductions in four steps.
constexpr std::array<IndexLanes, 4> kTurns = {IndexLanes{8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7},
                                              IndexLanes{4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11},
                                              IndexLanes{2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13},
                                              IndexLanes{1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12, 15, 14}};

// The largest of 2 × 16 candidates and where it is.
[[gnu::always_inline]] inline void reduce_largest(FloatLanes& best, IndexLanes& where, const FloatLanes& other,
                                                  const IndexLanes& other_where) {
  IndexLanes better = other > best;
  best = better ? other : best;
  where = better ? other_where : where;
  for (const IndexLanes& turn : kTurns) {
    const FloatLanes turned = __builtin_shuffle(best, turn);
    const IndexLanes turned_where = __builtin_shuffle(where, turn);
    better = turned > best;
    best = better ? turned : best;
    where = better ? turned_where : where;
  }
}

// response = up − down + kept · response, h −= moved · response, and the largest u = h − rise of the new h. `count` is
// a multiple of two lines of lanes.
GYROTHERM_CLONES
void move(float* h, float* response, const float* up, const float* down, float moved, float kept, const float* rise,
          int count, float& slope, int& index) {
  FloatLanes best[2] = {FloatLanes{} - kWall, FloatLanes{} - kWall};
  IndexLanes where[2] = {};
  IndexLanes at = kCount;
  for (int i = 0; i < count; i += 2 * kFloatLanes) {
    for (int half = 0; half < 2; ++half) {
      const int k = i + half * kFloatLanes;
      auto& error = *reinterpret_cast<UnalignedFloatLanes*>(h + k);
      auto& along = *reinterpret_cast<UnalignedFloatLanes*>(response + k);
      const FloatLanes change = lanes_at(up + k) - lanes_at(down + k) + kept * along;
      along = change;
      const FloatLanes changed = error - moved * change;
      error = changed;
      const FloatLanes u = changed - lanes_at(rise + k);
      const IndexLanes better = u > best[half];
      best[half] = better ? u : best[half];
      where[half] = better ? at : where[half];
    }
    at += 2 * kFloatLanes;
  }
  reduce_largest(best[0], where[0], best[1], where[1] + kFloatLanes);
  slope = best[0][0];
  index = where[0][0];
}

// Quotients square/curvature compared crosswise, without a division.
struct Candidate {
  FloatLanes square = {};
  FloatLanes curvature = FloatLanes{} + 1.0F;
  IndexLanes where = {};

  [[gnu::always_inline]] void take_better(const FloatLanes& other, const FloatLanes& other_curvature,
                                          const IndexLanes& other_where) {
    const IndexLanes better = other * curvature > square * other_curvature;
    square = better ? other : square;
    curvature = better ? other_curvature : curvature;
    where = better ? other_where : where;
  }
};

// The least v = h − fall, and the j of the largest (u_i − v_j)²/(2 − 2K_ij) among the v_j below `u`; `row` is K_i.
GYROTHERM_CLONES
void choose_partner(const float* row, const float* h, const float* fall, float u, int count, float& least_slope,
                    int& index) {
  FloatLanes least[2] = {FloatLanes{} + kWall, FloatLanes{} + kWall};
  Candidate best[2];
  IndexLanes at = kCount;
  const FloatLanes highest = FloatLanes{} + u;
  for (int i = 0; i < count; i += 2 * kFloatLanes) {
    for (int half = 0; half < 2; ++half) {
      const int k = i + half * kFloatLanes;
      const FloatLanes v = lanes_at(h + k) - lanes_at(fall + k);
      least[half] = v < least[half] ? v : least[half];
      const FloatLanes slack = u - (v < highest ? v : highest);
      best[half].take_better(slack * slack, 1.0F - lanes_at(row + k), at);
    }
    at += 2 * kFloatLanes;
  }
  least[0] = least[1] < least[0] ? least[1] : least[0];
  best[0].take_better(best[1].square, best[1].curvature, best[1].where + kFloatLanes);
  for (const IndexLanes& turn : kTurns) {
    const FloatLanes turned = __builtin_shuffle(least[0], turn);
    least[0] = turned < least[0] ? turned : least[0];
    best[0].take_better(__builtin_shuffle(best[0].square, turn), __builtin_shuffle(best[0].curvature, turn),
                        __builtin_shuffle(best[0].where, turn));
  }
  least_slope = least[0][0];
  index = best[0].where[0];
}

// How far β_i may rise and β_j fall together: the decrease per unit is `slack` at first, falls by `curvature`, and by
// 2ε where one of them passes zero.
double pair_step(double beta_i, double beta_j, double slack, double curvature, double C, double epsilon) {
  const double room = std::min(C - beta_i, beta_j + C);
  const double whole = slack / curvature;
  if (beta_i >= 0 && beta_j <= 0) return std::min(room, whole);
  constexpr double kNever = std::numeric_limits<double>::infinity();
  std::array<double, 2> kinks = {beta_i < 0 ? -beta_i : kNever, beta_j > 0 ? beta_j : kNever};
  if (kinks[1] < kinks[0]) std::swap(kinks[0], kinks[1]);
  double step = 0;
  for (const double kink : kinks) {
    const double end = std::min(kink, room);
    if (step + slack / curvature <= end) return step + slack / curvature;
    slack -= (end - step) * curvature + 2 * epsilon;
    step = end;
    if (step == room || slack <= 0) return step;
  }
  return std::min(room, step + slack / curvature);
}

double decrease(double slack, double curvature, double length) { return (slack - 0.5 * curvature * length) * length; }

}  // namespace

void SmoState::resize(int count) {
  stride_ = padded_row(count);
  h_.assign(stride_, 0);
  rise_.assign(stride_, kWall);
  fall_.assign(stride_, -kWall);
  response_.assign(stride_, 0);
  beta_.assign(count, 0);
  direction_.clear();
}

void SmoState::place(int i, double beta, float error) {
  h_[i] = error;
  set(i, beta);
}

void SmoState::set(int i, double beta) {
  const auto epsilon = static_cast<float>(epsilon_);
  beta_[i] = beta;
  const float rise = beta >= C_ ? kWall : beta >= 0 ? epsilon : -epsilon;
  const float fall = beta <= -C_ ? -kWall : beta > 0 ? epsilon : -epsilon;
  // Whole lanes are read soon, which would wait for what is written here.
  if (rise_[i] != rise) rise_[i] = rise;
  if (fall_[i] != fall) fall_[i] = fall;
}

SmoState::Steepest SmoState::steepest() const {
  Steepest found{-kWall, 0};
  for (int i = 0; i < static_cast<int>(beta_.size()); ++i) {
    if (u(i) > found.slope) found = {u(i), i};
  }
  return found;
}

SmoState::Partner SmoState::partner_of(const Steepest& first, const float* row) const {
  Partner found{};
  choose_partner(row, h_.data(), fall_.data(), first.slope, stride_, found.least_slope, found.index);
  return found;
}

// With the piece of the dual that β_i is on, or comes to when it leaves zero.
SmoDirection::Point SmoState::point(int i, bool rising) const {
  const double beta = beta_[i];
  const bool above = beta > 0 || (beta == 0 && rising);
  return {.index = i, .beta = beta, .low = above ? 0 : -C_, .high = above ? C_ : 0};
}

// False if the pair's own direction is the better one now; else `moved` is the length and `kept` the share of d.
bool SmoState::step_conjugately(const SmoPair& pair, float& moved, float& kept) {
  if (direction_.empty() || direction_.full()) return false;
  const double shared = static_cast<double>(response_[pair.i]) - static_cast<double>(response_[pair.j]);
  const double curvature = pair.curvature - shared * shared / curvature_;
  if (!(curvature > kLeastShare * pair.curvature)) return false;
  const double share = -shared / curvature_;
  direction_.turn(point(pair.i, true), point(pair.j, false), share);
  const auto length = direction_.reach(pair.slack / curvature);
  if (length.stopped_by >= 0) {
    const double alone = std::min({C_ - beta_[pair.i], beta_[pair.j] + C_, pair.slack / pair.curvature});
    if (decrease(pair.slack, curvature, length.units) <= decrease(pair.slack, pair.curvature, alone)) return false;
  }
  direction_.move(length);
  for (int p = 0; p < direction_.count(); ++p) beta_[direction_.index(p)] = direction_.beta(p);
  for (const int k : {pair.i, pair.j}) set(k, beta_[k]);  // they may have left zero
  if (length.stopped_by >= 0) {
    const int k = direction_.index(length.stopped_by);
    set(k, beta_[k]);
  }
  curvature_ = curvature;
  moved = static_cast<float>(length.units);
  kept = static_cast<float>(share);
  if (length.stopped_by >= 0) direction_.clear();
  return true;
}

// The length of the step; it goes through zeros, and starts conjugacy if nothing stopped it.
double SmoState::step_alone(const SmoPair& pair) {
  direction_.clear();
  const double beta_i = beta_[pair.i], beta_j = beta_[pair.j];
  const double length = pair_step(beta_i, beta_j, pair.slack, pair.curvature, C_, epsilon_);
  set(pair.i, length == C_ - beta_i ? C_ : beta_i + length);
  set(pair.j, length == beta_j + C_ ? -C_ : beta_j - length);
  const bool same_sides = beta_i * beta_[pair.i] >= 0 && beta_j * beta_[pair.j] >= 0;
  if (!same_sides || length != pair.slack / pair.curvature) return length;
  direction_.start(point(pair.i, true), point(pair.j, false));
  curvature_ = pair.curvature;
  return length;
}

SmoState::Steepest SmoState::step(const Steepest& first, int second, const float* up, const float* down) {
  const SmoPair pair{.i = first.index,
                     .j = second,
                     .slack = double{first.slope} - double{h_[second]} + double{fall_[second]},
                     .curvature = std::max(2.0F - 2.0F * up[second], kLeastCurvature)};
  float moved = 0, kept = 0;
  if (!step_conjugately(pair, moved, kept)) moved = static_cast<float>(step_alone(pair));
  Steepest next{};
  move(h_.data(), response_.data(), up, down, moved, kept, rise_.data(), stride_, next.slope, next.index);
  return next;
}

}  // namespace gyrotherm
