// SPDX-License-Identifier: Apache-2.0
#include "analysis/model/selection.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "analysis/data/features.hpp"
#include "analysis/data/statistics.hpp"

namespace gyrotherm::model {
namespace {

std::string join_names(const std::vector<data::Term>& terms) {
  std::vector<std::string> names;
  for (const data::Term& term : terms) names.push_back(to_string(term));
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

bool are_all_gradients(const std::vector<data::Term>& terms) {
  return std::ranges::all_of(terms, [](const data::Term& term) {
    return term.factors.size() == 1 && term.factors.front().kind == data::FactorKind::gradient;
  });
}

std::string make_statement(const Selection& selection, const std::vector<data::Term>& candidates, std::size_t passed) {
  const std::string of = fmt::format("{} of {} {} have |r| > {}", passed, candidates.size(),
                                     are_all_gradients(candidates) ? "gradients" : "inputs", selection.threshold);
  const std::string what = fmt::format("{} (rank {})", join_names(selection.terms), selection.rank);
  if (!selection.fallback) return of + ": " + what;
  return of + ", too few to choose from; the inputs independent of earlier ones are used: " + what;
}

/// Returns the candidates that do not depend linearly on earlier ones, for any temperatures.
std::vector<data::Term> find_independent_terms(const std::vector<data::Term>& candidates) {
  std::vector<data::Term> taken;
  for (const data::Term& term : candidates) {
    taken.push_back(term);
    if (polynomial_rank(taken) < static_cast<int>(taken.size())) taken.pop_back();
  }
  return taken;
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc{} && read.ptr == text.data() + text.size();
}

/// Centres the columns and scales them to length 1; a constant column becomes 0.
Eigen::MatrixXd normalise_columns(const data::SampleMatrix& values) {
  constexpr double kRounding = 1e-12;
  Eigen::MatrixXd unit = values.rowwise() - values.colwise().mean();
  for (Eigen::Index j = 0; j < unit.cols(); ++j) {
    const double length = unit.col(j).norm();
    if (length > kRounding * values.col(j).norm())
      unit.col(j) /= length;
    else
      unit.col(j).setZero();
  }
  return unit;
}

/// Removes the projection onto the columns of `fixed`, twice, which makes the remainder orthogonal within rounding.
void project_out(const Eigen::MatrixXd& fixed, Eigen::MatrixXd& columns) {
  if (fixed.cols() == 0) return;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(fixed);
  const Eigen::MatrixXd basis = qr.householderQ() * Eigen::MatrixXd::Identity(fixed.rows(), qr.rank());
  for (int pass = 0; pass < 2; ++pass) columns -= basis * (basis.transpose() * columns);
}

using Columns = std::vector<Eigen::Index>;

/// A step of the forward selection: the added input, and the trial of the surface with all inputs so far.
struct Step {
  Eigen::Index column{};
  SurfaceTrial trial;
};

/// All inputs: the fixed ones first, then the candidates.
struct SelectionProblem {
  data::SampleMatrix x;
  const data::TrainingSet& training_set;
  std::size_t fixed;

  [[nodiscard]] SurfaceTrial try_columns(const Columns& columns) const {
    return try_surface(x(Eigen::all, columns), training_set.clusters.bias_deg_per_h, training_set.folds);
  }
};

/// Returns the best of the candidates that are not yet selected; the first of equals.
Step find_next_step(const SelectionProblem& problem, const Columns& taken) {
  std::vector<Step> steps;
  for (Eigen::Index column = static_cast<Eigen::Index>(problem.fixed); column < problem.x.cols(); ++column) {
    if (std::ranges::count(taken, column) == 0) steps.push_back({column, {}});
  }
  tbb::parallel_for(std::size_t{0}, steps.size(), [&](std::size_t i) {
    Columns columns = taken;
    columns.push_back(steps[i].column);
    steps[i].trial = problem.try_columns(columns);
  });
  return *std::ranges::min_element(steps, {}, [](const Step& step) { return step.trial.mean_square; });
}

/// Adds inputs while the held-out error decreases. Without fixed inputs, the first candidate is added in any case.
std::vector<Step> extend_selection(const SelectionProblem& problem, const SurfaceTrial& start, std::size_t most) {
  Columns taken(problem.fixed);
  std::iota(taken.begin(), taken.end(), Eigen::Index{0});
  std::vector<Step> path;
  double error = start.mean_square;
  while (path.size() < most && taken.size() < static_cast<std::size_t>(problem.x.cols())) {
    Step step = find_next_step(problem, taken);
    if (!(step.trial.mean_square < error) && !taken.empty()) break;
    error = step.trial.mean_square;
    taken.push_back(step.column);
    path.push_back(std::move(step));
  }
  return path;
}

/// Returns the standard error of the mean squared error, from the effective number of squared residuals.
double error_of_mean_square(const SurfaceTrial& trial, const data::Clusters& clusters) {
  const auto rows = data::finite_rows(trial.residual);
  return standard_error_of_mean(compute_figures(trial.residual(rows).array().square().matrix(), clusters, rows));
}

/// Returns the number of steps of the path to keep. The last step of the path has the least error.
std::size_t count_steps_to_keep(const std::vector<Step>& path, const SurfaceTrial& start,
                                const SelectionProblem& problem) {
  if (path.empty()) return 0;
  const SurfaceTrial& best = path.back().trial;
  const double acceptable = best.mean_square + error_of_mean_square(best, problem.training_set.clusters);
  if (problem.fixed > 0 && start.mean_square <= acceptable) return 0;
  std::size_t kept = 1;
  while (path[kept - 1].trial.mean_square > acceptable) ++kept;
  return kept;
}

/// Mean and 1/STD of each column; 0 instead of 1/STD for a constant column.
struct Standard {
  explicit Standard(const svm::SampleMatrix& values)
      : mean(values.colwise().mean()), inverse_std(Eigen::RowVectorXd::Zero(values.cols())) {
    constexpr double kRounding = 1e-12;
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      const double std =
          std::sqrt((values.col(j).array() - mean(j)).square().sum() / static_cast<double>(values.rows()));
      if (std > kRounding * values.col(j).cwiseAbs().maxCoeff()) inverse_std(j) = 1 / std;
    }
  }
  [[nodiscard]] svm::SampleMatrix of(const svm::SampleMatrix& values) const {
    return ((values.rowwise() - mean).array().rowwise() * inverse_std.array()).matrix();
  }
  Eigen::RowVectorXd mean, inverse_std;
};

/// Returns z_i, then z_i z_j for i ≤ j.
svm::SampleMatrix expand_to_second_order(const svm::SampleMatrix& z) {
  const Eigen::Index inputs = z.cols();
  svm::SampleMatrix all(z.rows(), inputs + inputs * (inputs + 1) / 2);
  all.leftCols(inputs) = z;
  Eigen::Index column = inputs;
  for (Eigen::Index i = 0; i < inputs; ++i) {
    const Eigen::Index products = inputs - i;
    all.middleCols(column, products) = z.rightCols(products).array().colwise() * z.col(i).array();
    column += products;
  }
  return all;
}

}  // namespace

Result<SelectionRule> parse_selection(std::string_view text) {
  const auto colon = text.find(':');
  const auto keyword = text.substr(0, colon);
  const bool numbered = colon != text.npos;
  const auto number = numbered ? text.substr(colon + 1) : std::string_view{};
  SelectionRule rule;
  if (keyword == "correlation") {
    rule.kind = SelectionKind::correlation;
    if (!numbered || (read_number(number, rule.threshold) && rule.threshold >= 0 && rule.threshold <= 1)) return rule;
  } else if (keyword == "forward") {
    rule.kind = SelectionKind::forward;
    if (!numbered || (read_number(number, rule.most) && rule.most >= 1)) return rule;
  } else if (keyword == "redundancy") {
    rule.kind = SelectionKind::redundancy;
    if (!numbered || (read_number(number, rule.tolerance) && rule.tolerance > 0 && rule.tolerance < 1)) return rule;
  }
  return failure(
      FaultKind::usage, "--select",
      fmt::format("\"{}\" is not a rule, expected correlation[:R] with R from 0 to 1, forward[:N] with N at least 1 or "
                  "redundancy[:PART] with PART between 0 and 1",
                  text));
}

Selection select_by_correlation(const std::vector<data::Term>& candidates, const std::vector<double>& r,
                                double threshold, int least_rank) {
  assert(candidates.size() == r.size());
  Selection selection;
  selection.threshold = threshold;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (std::abs(r[i]) > threshold) selection.terms.push_back(candidates[i]);
  }
  const std::size_t passed = selection.terms.size();
  selection.rank = polynomial_rank(selection.terms);
  if (selection.rank < least_rank) {
    selection.fallback = true;
    selection.terms = find_independent_terms(candidates);
    selection.rank = polynomial_rank(selection.terms);
  }
  selection.statement = make_statement(selection, candidates, passed);
  return selection;
}

Result<Selection> select_inputs(const SelectionRule& rule, const std::vector<data::Term>& fixed,
                                const std::vector<data::Term>& candidates, const data::TrainingSet& training_set) {
  if (candidates.empty()) return failure(FaultKind::usage, "selection", "no inputs to select from");
  switch (rule.kind) {
    case SelectionKind::forward: return select_forward(fixed, candidates, training_set, rule.most);
    case SelectionKind::redundancy: return select_independent(fixed, candidates, training_set.clusters, rule.tolerance);
    case SelectionKind::correlation: break;
  }
  const auto inputs = evaluate(candidates, training_set.clusters);
  if (!inputs) return failure(inputs.error());
  std::vector<double> r;
  for (Eigen::Index j = 0; j < inputs->cols(); ++j)
    r.push_back(data::pearson(inputs->col(j), training_set.clusters.bias_deg_per_h));
  constexpr int kLeastRank = 2;  // a single gradient leaves no choice
  return select_by_correlation(candidates, r, rule.threshold, std::min(kLeastRank, polynomial_rank(candidates)));
}

Result<Selection> select_independent(const std::vector<data::Term>& fixed, const std::vector<data::Term>& candidates,
                                     const data::Clusters& training, double tolerance) {
  const auto taken = evaluate(fixed, training);
  if (!taken) return failure(taken.error());
  const auto offered = evaluate(candidates, training);
  if (!offered) return failure(offered.error());
  Eigen::MatrixXd columns = normalise_columns(*offered);
  project_out(normalise_columns(*taken), columns);

  // Each pivot is the column with the largest independent part; the diagonal of R is the size of this part.
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  const Eigen::Index most = std::min(columns.rows(), columns.cols());
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < most && std::abs(qr.matrixR()(k, k)) > tolerance; ++k)
    kept.push_back(qr.colsPermutation().indices()(k));
  std::ranges::sort(kept);

  Selection selection;
  selection.threshold = 0;
  for (const Eigen::Index column : kept) selection.terms.push_back(candidates[column]);
  selection.rank = polynomial_rank(selection.terms);
  selection.statement =
      fmt::format("{} of {} inputs are independent by more than {:g} of their STD: {} (rank {})", kept.size(),
                  candidates.size(), tolerance, join_names(selection.terms), selection.rank);
  return selection;
}

Result<Selection> select_forward(const std::vector<data::Term>& fixed, const std::vector<data::Term>& candidates,
                                 const data::TrainingSet& training_set, int most) {
  const auto divided = ensure_two_folds(training_set);
  if (!divided) return failure(divided.error());
  std::vector<data::Term> terms = fixed;
  terms.insert(terms.end(), candidates.begin(), candidates.end());
  auto x = evaluate(terms, training_set.clusters);
  if (!x) return failure(x.error());
  const SelectionProblem problem{.x = std::move(*x), .training_set = *divided, .fixed = fixed.size()};
  Columns at_first(fixed.size());
  std::iota(at_first.begin(), at_first.end(), Eigen::Index{0});
  const SurfaceTrial start = problem.try_columns(at_first);
  const std::vector<Step> path = extend_selection(problem, start, static_cast<std::size_t>(most));
  const std::size_t kept = count_steps_to_keep(path, start, problem);

  Selection selection;
  selection.threshold = 0;
  for (std::size_t k = 0; k < kept; ++k) selection.terms.push_back(terms[path[k].column]);
  selection.rank = polynomial_rank(selection.terms);
  const double error = std::sqrt(kept > 0 ? path[kept - 1].trial.mean_square : start.mean_square);
  selection.statement = fmt::format(
      "forward by held-out gain, {} of {} inputs: {} (rank {}); a response surface of {} has a held-out "
      "RMSE of {:.4g} °/h",
      kept, candidates.size(), join_names(selection.terms), selection.rank,
      fixed.empty() ? "these" : "these and the fixed inputs", error);
  return selection;
}

Eigen::MatrixXd surface_predictions(const svm::SampleMatrix& train_x, const Eigen::VectorXd& train_y,
                                    const svm::SampleMatrix& test_x, std::span<const double> lambdas) {
  assert(train_x.rows() == train_y.size() && train_x.rows() > 0 && train_x.cols() == test_x.cols());
  const auto count = static_cast<Eigen::Index>(lambdas.size());
  const double mean = train_y.mean();
  Eigen::MatrixXd predicted = Eigen::MatrixXd::Constant(test_x.rows(), count, mean);
  if (train_x.cols() == 0) return predicted;

  const Standard inputs(train_x);
  const svm::SampleMatrix raw = expand_to_second_order(inputs.of(train_x));
  const Standard products(raw);
  const svm::SampleMatrix train = products.of(raw);
  const svm::SampleMatrix test = products.of(expand_to_second_order(inputs.of(test_x)));
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(train.cols(), train.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(train.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(gram);  // reads the lower triangle
  const Eigen::VectorXd pull =
      modes.eigenvectors().transpose() * (train.transpose() * (train_y.array() - mean).matrix());
  const Eigen::MatrixXd along = test * modes.eigenvectors();
  const Eigen::ArrayXd strength = modes.eigenvalues().array().max(0);
  for (Eigen::Index l = 0; l < count; ++l) {
    const double penalty = lambdas[l] * static_cast<double>(train.rows());
    predicted.col(l) += along * (pull.array() / (strength + penalty)).matrix();
  }
  return predicted;
}

SurfaceTrial try_surface(const svm::SampleMatrix& x, const Eigen::VectorXd& y, const data::FoldPlan& folds) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr auto kLambdas = static_cast<Eigen::Index>(kSurfaceLambdas.size());
  Eigen::MatrixXd residual = Eigen::MatrixXd::Constant(y.size(), kLambdas, kNone);
  Eigen::RowVectorXd squares = Eigen::RowVectorXd::Zero(kLambdas);
  Eigen::Index held_out = 0;
  for (const data::Fold& fold : folds.folds) {
    const Eigen::MatrixXd predicted = surface_predictions(x(fold.training, Eigen::all), y(fold.training),
                                                          x(fold.held_out, Eigen::all), kSurfaceLambdas);
    const Eigen::VectorXd truth = y(fold.held_out);
    const Eigen::MatrixXd left = truth.replicate(1, kLambdas) - predicted;
    squares += left.colwise().squaredNorm();
    held_out += left.rows();
    residual(fold.held_out, Eigen::all) = left;
  }
  assert(held_out > 0);
  Eigen::Index best = 0;
  squares.minCoeff(&best);
  return {.residual = residual.col(best),
          .lambda = kSurfaceLambdas[best],
          .mean_square = squares(best) / static_cast<double>(held_out)};
}

}  // namespace gyrotherm::model
