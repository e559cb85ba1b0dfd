// SPDX-License-Identifier: Apache-2.0
#include "analysis/svm/smo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/svm/kernel.hpp"
#include "analysis/svm/lanes.hpp"
#include "analysis/svm/smo_loops.hpp"

namespace gyrotherm::svm {
namespace {

// Returns whether a point that moves by `units` times its part leaves its range.
GYROTHERM_CLONES
bool is_outside_range(const double* part, const double* beta, const double* low, const double* high, double units) {
  int passing = 0;
  for (int p = 0; p < SmoDirection::kEntries; ++p) {
    const double there = beta[p] + units * part[p];
    passing += (there > high[p]) + (there < low[p]);
  }
  return passing > 0;
}

constexpr float kLeastCurvature = 1e-12F;
// Smallest curvature of a conjugate direction, as a fraction of the curvature of the pair's own direction.
constexpr double kLeastShare = 1e-3;

#if GYROTHERM_HAS_VERSIONS
GYROTHERM_V4
SmoSteepest move(SmoLines lines, const float* up, const float* down, SmoStep step) {
  return move_points<Registers64>(lines, up, down, step);
}
GYROTHERM_V3
SmoSteepest move(SmoLines lines, const float* up, const float* down, SmoStep step) {
  return move_points<Registers32>(lines, up, down, step);
}
GYROTHERM_V4
SmoPartner choose_partner(const float* row, const float* h, const float* fall, float u, int count) {
  return find_partner<Registers64>(row, h, fall, u, count);
}
GYROTHERM_V3
SmoPartner choose_partner(const float* row, const float* h, const float* fall, float u, int count) {
  return find_partner<Registers32>(row, h, fall, u, count);
}
#endif

GYROTHERM_DEFAULT
SmoSteepest move(SmoLines lines, const float* up, const float* down, SmoStep step) {
  return move_points<Registers16>(lines, up, down, step);
}
GYROTHERM_DEFAULT
SmoPartner choose_partner(const float* row, const float* h, const float* fall, float u, int count) {
  return find_partner<Registers16>(row, h, fall, u, count);
}

// Returns the distance by which β_i may rise and β_j fall together. The decrease per unit is initially `slack`. The
// decrease per unit shrinks by `curvature` per unit, and by 2ε where β_i or β_j passes zero.
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

// Number of points in a working set. The rows of a set take 1 MiB.
constexpr int kWorkingSet = 512;
// Problems up to this size use all points as their working set.
constexpr int kMaxSmallProblem = 640;
// A working set is optimised until its violation is reduced by this factor …
constexpr double kInnerFraction = 0.1;
// … or for this many iterations per point.
constexpr int kInnerIterations = 10;
// After this many iterations per point of the whole problem, Newton steps are faster if at most this fraction of the
// points is free.
constexpr int kIterationsBeforeFew = 4;
constexpr double kFewFreeShare = 0.08;
constexpr int kRowsAtOnce = 4;

GYROTHERM_CLONES
void subtract_rows(const float* const* rows, const float* weights, int count, float* sum) {
  for (int i = 0; i < count; ++i) {
    sum[i] -= weights[0] * rows[0][i] + weights[1] * rows[1][i] + weights[2] * rows[2][i] + weights[3] * rows[3][i];
  }
}

GYROTHERM_CLONES
void gather(const float* row, const int* indices, int count, float* out) {
  for (int i = 0; i < count; ++i) out[i] = row[indices[i]];
}

// Optimisation of one working set after another.
class Decomposition {
 public:
  Decomposition(const SvrProblem& problem, SmoState& all)
      : problem_(problem),
        all_(all),
        n_(static_cast<int>(problem.size())),
        slope_(n_),
        chosen_(n_),
        block_(problem.C, problem.epsilon) {}

  /// Continues from the state of `run`.
  void run(double tolerance, int most, SmoRun& run);

 private:
  [[nodiscard]] double violation() const;
  [[nodiscard]] bool has_few_free_points() const;
  void choose();
  void take_steepest(int count);
  void keep(bool free);
  SmoRun optimise(double tolerance, int most);
  void update_errors();

  const SvrProblem& problem_;
  SmoState& all_;
  int n_;
  std::vector<float> slope_;
  std::vector<char> chosen_;
  std::vector<int> order_;
  std::vector<int> set_;
  std::vector<int> next_;
  // Kernel rows of the points in the working set, restricted to the set. Row p is valid if has_row_[p] is set.
  std::vector<float> rows_;
  std::vector<char> has_row_;
  SmoState block_;
};

double Decomposition::violation() const {
  float highest = all_.u(0), lowest = all_.v(0);
  for (int i = 1; i < n_; ++i) {
    highest = std::max(highest, all_.u(i));
    lowest = std::min(lowest, all_.v(i));
  }
  return static_cast<double>(highest) - static_cast<double>(lowest);
}

bool Decomposition::has_few_free_points() const {
  const auto free =
      std::ranges::count_if(all_.beta(), [&](double beta) { return beta != 0 && std::abs(beta) < problem_.C; });
  return static_cast<double>(free) <= kFewFreeShare * n_;
}

// Adds the `count` points with the largest slope that are not yet chosen. Among equal slopes the first is taken.
void Decomposition::take_steepest(int count) {
  order_.clear();
  for (int i = 0; i < n_; ++i) {
    if (chosen_[i] == 0) order_.push_back(i);
  }
  const auto end = order_.begin() + std::min(static_cast<int>(order_.size()), count);
  std::nth_element(order_.begin(), end, order_.end(),
                   [&](int a, int b) { return slope_[a] > slope_[b] || (slope_[a] == slope_[b] && a < b); });
  for (auto i = order_.begin(); i != end; ++i) chosen_[*i] = 1;
  next_.insert(next_.end(), order_.begin(), end);
}

// Adds points of the previous set, either the free ones or the others.
void Decomposition::keep(bool free) {
  for (const int i : set_) {
    if (static_cast<int>(next_.size()) >= kWorkingSet) return;
    const double beta = all_.beta(i);
    if (chosen_[i] != 0 || (beta != 0 && std::abs(beta) < problem_.C) != free) continue;
    chosen_[i] = 1;
    next_.push_back(i);
  }
}

// Chooses the next set: half are the most violating points in either direction, half are kept from the previous set.
void Decomposition::choose() {
  const int fresh = set_.empty() ? kWorkingSet : kWorkingSet / 2;
  std::fill(chosen_.begin(), chosen_.end(), 0);
  next_.clear();
  for (int i = 0; i < n_; ++i) slope_[i] = all_.u(i);
  take_steepest(fresh / 2);
  for (int i = 0; i < n_; ++i) slope_[i] = -all_.v(i);
  take_steepest(fresh / 2);
  keep(true);
  keep(false);
  std::sort(next_.begin(), next_.end());
  set_ = next_;
}

SmoRun Decomposition::optimise(double tolerance, int most) {
  const int count = static_cast<int>(set_.size());
  block_.resize(count);
  rows_.resize(static_cast<std::size_t>(count) * block_.stride());
  has_row_.assign(count, 0);
  for (int p = 0; p < count; ++p) block_.set_point(p, all_.beta(set_[p]), all_.error(set_[p]));
  // Computed on demand, since many points of a set never move.
  const auto kernel_row = [&](int p) {
    float* row = rows_.data() + static_cast<std::size_t>(p) * block_.stride();
    if (has_row_[p] == 0) gather(problem_.kernel.row(set_[p]), set_.data(), count, row);
    has_row_[p] = 1;
    return row;
  };
  return block_.run(kernel_row, tolerance, kInnerFraction, std::min(most, kInnerIterations * count));
}

// Updates the errors of all points for the new β of the working set.
void Decomposition::update_errors() {
  std::array<const float*, kRowsAtOnce> rows{};
  std::array<float, kRowsAtOnce> weights{};
  int filled = 0;
  const auto subtract = [&] { subtract_rows(rows.data(), weights.data(), all_.stride(), all_.errors()); };
  for (int p = 0; p < static_cast<int>(set_.size()); ++p) {
    const double change = block_.beta(p) - all_.beta(set_[p]);
    if (change == 0) continue;
    rows[filled] = problem_.kernel.row(set_[p]);
    weights[filled] = static_cast<float>(change);
    all_.set(set_[p], block_.beta(p));
    if (++filled < kRowsAtOnce) continue;
    subtract();
    filled = 0;
  }
  if (filled == 0) return;
  std::fill(rows.begin() + filled, rows.end(), rows[0]);
  std::fill(weights.begin() + filled, weights.end(), 0.0F);
  subtract();
}

void Decomposition::run(double tolerance, int most, SmoRun& run) {
  while (true) {
    run.violation = violation();
    if (run.violation <= tolerance || run.iterations >= most) return;
    choose();
    const SmoRun inner = optimise(tolerance, most - run.iterations);
    if (inner.iterations == 0) return;
    run.iterations += inner.iterations;
    update_errors();
    if (run.iterations >= kIterationsBeforeFew * n_ && has_few_free_points()) return;
  }
}

}  // namespace

void SmoDirection::clear() {
  part_.fill(0);
  beta_.fill(0);
  low_.fill(0);
  high_.fill(0);
  count_ = 0;
  steps_ = 0;
}

int SmoDirection::find_entry(const Point& point) {
  for (int p = 0; p < count_; ++p) {
    if (index_[p] == point.index) return p;
  }
  index_[count_] = point.index;
  beta_[count_] = point.beta;
  low_[count_] = point.low;
  high_[count_] = point.high;
  return count_++;
}

void SmoDirection::start(const Point& i, const Point& j) {
  clear();
  part_[find_entry(i)] = 1;
  part_[find_entry(j)] = -1;
}

void SmoDirection::set_direction(const Point& i, const Point& j, double kept) {
  for (double& part : part_) part *= kept;
  part_[find_entry(i)] += 1;
  part_[find_entry(j)] -= 1;
  ++steps_;
}

SmoDirection::Length SmoDirection::reach(double units) const {
  Length length{units, -1};
  if (!is_outside_range(part_.data(), beta_.data(), low_.data(), high_.data(), units)) return length;
  for (int p = 0; p < count_; ++p) {
    const double room = (part_[p] > 0 ? high_[p] : low_[p]) - beta_[p];
    if (std::abs(room) < length.units * std::abs(part_[p])) length = {room / part_[p], p};
  }
  return length;
}

void SmoDirection::move(const Length& length) {
  for (int p = 0; p < count_; ++p) {
    beta_[p] = std::clamp(beta_[p] + length.units * part_[p], low_[p], high_[p]);
  }
  if (const int p = length.stopped_by; p >= 0) beta_[p] = part_[p] > 0 ? high_[p] : low_[p];
}

void SmoState::resize(int count) {
  stride_ = padded_row(count);
  h_.assign(stride_, 0);
  rise_.assign(stride_, kBlockingSlope);
  fall_.assign(stride_, -kBlockingSlope);
  response_.assign(stride_, 0);
  beta_.assign(count, 0);
  direction_.clear();
}

void SmoState::set_point(int i, double beta, float error) {
  h_[i] = error;
  set(i, beta);
}

void SmoState::set(int i, double beta) {
  const auto epsilon = static_cast<float>(epsilon_);
  beta_[i] = beta;
  const float rise = beta >= C_ ? kBlockingSlope : beta >= 0 ? epsilon : -epsilon;
  const float fall = beta <= -C_ ? -kBlockingSlope : beta > 0 ? epsilon : -epsilon;
  // Avoids a write if the value is unchanged. Whole lanes are read soon afterwards and would wait for it.
  if (rise_[i] != rise) rise_[i] = rise;
  if (fall_[i] != fall) fall_[i] = fall;
}

SmoSteepest SmoState::steepest() const {
  SmoSteepest found{-kBlockingSlope, 0};
  for (int i = 0; i < static_cast<int>(beta_.size()); ++i) {
    if (u(i) > found.slope) found = {u(i), i};
  }
  return found;
}

SmoPartner SmoState::find_partner(const SmoSteepest& first, const float* row) const {
  return choose_partner(row, h_.data(), fall_.data(), first.slope, stride_);
}

// Returns the point with the range of the quadratic piece that contains β_i. If β_i is 0, `rising` selects the piece.
SmoDirection::Point SmoState::point(int i, bool rising) const {
  const double beta = beta_[i];
  const bool above = beta > 0 || (beta == 0 && rising);
  return {.index = i, .beta = beta, .low = above ? 0 : -C_, .high = above ? C_ : 0};
}

// Moves the points along the direction made conjugate to the last one. Returns nothing and moves nothing if the
// direction of the pair itself is better.
std::optional<SmoStep> SmoState::step_conjugately(const SmoPair& pair) {
  if (direction_.empty() || direction_.is_full()) return {};
  const double shared = static_cast<double>(response_[pair.i]) - static_cast<double>(response_[pair.j]);
  const double curvature = pair.curvature - shared * shared / curvature_;
  if (!(curvature > kLeastShare * pair.curvature)) return {};
  const double share = -shared / curvature_;
  direction_.set_direction(point(pair.i, true), point(pair.j, false), share);
  const auto length = direction_.reach(pair.slack / curvature);
  if (length.stopped_by >= 0) {
    const double alone = std::min({C_ - beta_[pair.i], beta_[pair.j] + C_, pair.slack / pair.curvature});
    if (decrease(pair.slack, curvature, length.units) <= decrease(pair.slack, pair.curvature, alone)) return {};
  }
  direction_.move(length);
  for (int p = 0; p < direction_.count(); ++p) beta_[direction_.index(p)] = direction_.beta(p);
  for (const int k : {pair.i, pair.j}) set(k, beta_[k]);  // they may have left zero
  if (length.stopped_by >= 0) {
    const int k = direction_.index(length.stopped_by);
    set(k, beta_[k]);
  }
  curvature_ = curvature;
  if (length.stopped_by >= 0) direction_.clear();
  return SmoStep{.length = static_cast<float>(length.units), .kept = static_cast<float>(share)};
}

// Moves only the pair, through zeros if necessary. Starts a sequence of conjugate steps unless the step met a bound or
// kink.
SmoStep SmoState::step_alone(const SmoPair& pair) {
  direction_.clear();
  const double beta_i = beta_[pair.i], beta_j = beta_[pair.j];
  const double length = pair_step(beta_i, beta_j, pair.slack, pair.curvature, C_, epsilon_);
  set(pair.i, length == C_ - beta_i ? C_ : beta_i + length);
  set(pair.j, length == beta_j + C_ ? -C_ : beta_j - length);
  const bool same_sides = beta_i * beta_[pair.i] >= 0 && beta_j * beta_[pair.j] >= 0;
  const SmoStep step{.length = static_cast<float>(length)};
  if (!same_sides || length != pair.slack / pair.curvature) return step;
  direction_.start(point(pair.i, true), point(pair.j, false));
  curvature_ = pair.curvature;
  return step;
}

SmoSteepest SmoState::step(const SmoSteepest& first, int second, const float* up, const float* down) {
  const SmoPair pair{.i = first.index,
                     .j = second,
                     .slack = double{first.slope} - double{h_[second]} + double{fall_[second]},
                     .curvature = std::max(2.0F - 2.0F * up[second], kLeastCurvature)};
  const std::optional<SmoStep> conjugate = step_conjugately(pair);
  const SmoStep taken = conjugate ? *conjugate : step_alone(pair);
  return move({.h = h_.data(), .response = response_.data(), .rise = rise_.data(), .count = stride_}, up, down, taken);
}

Eigen::VectorXd solve_by_smo(const SvrProblem& problem, double tolerance, int most, const Eigen::VectorXd* start) {
  const int n = static_cast<int>(problem.size());
  SmoState all(problem.C, problem.epsilon);
  all.resize(n);
  if (start == nullptr) {
    for (int i = 0; i < n; ++i) all.set_point(i, 0, static_cast<float>(problem.y[i]));
  } else {
    const Eigen::VectorXd error = problem.y - problem.kernel.response(*start);
    for (int i = 0; i < n; ++i) all.set_point(i, (*start)[i], static_cast<float>(error[i]));
  }
  const auto kernel_row = [&](int i) { return problem.kernel.row(i); };
  const bool small = n <= kMaxSmallProblem;
  // Few points move from a given start, so a working set is chosen immediately.
  const int all_iterations = small ? most : start == nullptr ? std::min(most, n) : 0;
  SmoRun run = all.run(kernel_row, tolerance, 0, all_iterations);
  if (!small && run.violation > tolerance) Decomposition(problem, all).run(tolerance, most, run);
  return Eigen::Map<const Eigen::VectorXd>(all.beta().data(), n);
}

}  // namespace gyrotherm::svm
