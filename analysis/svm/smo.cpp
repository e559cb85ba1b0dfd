#include "analysis/svm/smo.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "analysis/svm/lanes.hpp"
#include "analysis/svm/smo_state.hpp"

namespace gyrotherm {
namespace {

// Points of a working set: its rows take a megabyte.
constexpr int kWorkingSet = 512;
// Sets of all points up to this size are their own working set.
constexpr int kSmall = 640;
// A working set is optimised until its violation is this part of what it was …
constexpr double kInnerFraction = 0.1;
// … or for so many iterations per point.
constexpr int kInnerIterations = 10;
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

// Working set after working set.
class Decomposition {
 public:
  Decomposition(const SvrProblem& problem, SmoState& all)
      : problem_(problem),
        all_(all),
        n_(static_cast<int>(problem.size())),
        slope_(n_),
        chosen_(n_),
        block_(problem.C, problem.epsilon) {}

  /// Goes on from `run`.
  void run(double tolerance, int most, SmoRun& run);

 private:
  [[nodiscard]] double violation() const;
  void choose();
  void take_steepest(int count);
  void keep(bool free);
  SmoRun optimise(double tolerance, int most);
  void follow();

  const SvrProblem& problem_;
  SmoState& all_;
  int n_;
  std::vector<float> slope_;
  std::vector<char> chosen_;
  std::vector<int> order_;
  std::vector<int> set_;
  std::vector<int> next_;
  std::vector<float> rows_;  // of the working set among itself
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

// The `count` points of the largest slope that are not in yet; of equal ones the first.
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

// Points of the last set, the free ones or the others.
void Decomposition::keep(bool free) {
  for (const int i : set_) {
    if (static_cast<int>(next_.size()) >= kWorkingSet) return;
    const double beta = all_.beta(i);
    if (chosen_[i] != 0 || (beta != 0 && std::abs(beta) < problem_.C) != free) continue;
    chosen_[i] = 1;
    next_.push_back(i);
  }
}

// Half of the set are the most violating points of either direction, half is left of the last set.
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
  for (int p = 0; p < count; ++p) {
    gather(problem_.kernel.row(set_[p]), set_.data(), count,
           rows_.data() + static_cast<std::size_t>(p) * block_.stride());
    block_.place(p, all_.beta(set_[p]), all_.error(set_[p]));
  }
  const auto row_of = [&](int p) { return rows_.data() + static_cast<std::size_t>(p) * block_.stride(); };
  return block_.run(row_of, tolerance, kInnerFraction, std::min(most, kInnerIterations * count));
}

// The errors of all points follow the β of the working set.
void Decomposition::follow() {
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
    follow();
  }
}

}  // namespace

SmoResult solve_by_smo(const SvrProblem& problem, double tolerance, int most) {
  const int n = static_cast<int>(problem.size());
  SmoState all(problem.C, problem.epsilon);
  all.resize(n);
  for (int i = 0; i < n; ++i) all.place(i, 0, static_cast<float>(problem.y[i]));
  const auto row_of = [&](int i) { return problem.kernel.row(i); };
  const bool small = n <= kSmall;
  SmoRun run = all.run(row_of, tolerance, 0, small ? most : std::min(most, n));
  if (!small && run.violation > tolerance) Decomposition(problem, all).run(tolerance, most, run);
  return {.beta = Eigen::Map<const Eigen::VectorXd>(all.beta().data(), n),
          .iterations = run.iterations,
          .converged = run.violation <= tolerance};
}

}  // namespace gyrotherm
