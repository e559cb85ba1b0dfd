// SPDX-License-Identifier: Apache-2.0
#include "analysis/assurance/diagnosis.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "acquisition/record/run_info.hpp"
#include "analysis/data/distributions.hpp"

namespace gyrotherm::assurance {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEarthRate = 15.041067;  // °/h
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kReferenceC = 20, kSpanK = 30;  // scale of changes with temperature
constexpr std::size_t kMostRunsSince = 15, kFewestBefore = 4;
constexpr double kSmallestChangeK = 0.05;  // standard deviation of a thermometer a priori
constexpr double kSmallestNoiseK = 1e-4, kSmallestNoise = 1e-6;
constexpr double kScatterChange = 0.3;  // relative

/// Results that vary together from run to run: the biases of an axis, or the thermometers of a unit.
struct Group {
  CheckKind kind{};
  std::string axis{};
  std::vector<Index> members{};  ///< rows of y
};

/// The results that are compared: all but temperature coefficients and Earth rates, which follow from the biases, and
/// the last thermometer of each unit and plateau, which follows from the others.
class Layout {
 public:
  explicit Layout(const Assessment& assessment) {
    for (std::size_t c = 0; c < assessment.charts.size(); ++c) {
      const CheckResult& of = assessment.charts[c].of;
      if (of.kind == CheckKind::temperature_coefficient || of.kind == CheckKind::earth_rate) continue;
      if (of.kind == CheckKind::thermometer && is_last(assessment, c)) continue;
      group(of).members.push_back(std::ssize(charts));
      charts.push_back(c);
      rows.push_back(of);
    }
  }
  [[nodiscard]] Index size() const { return std::ssize(rows); }

  std::vector<std::size_t> charts;  ///< chart of each row
  std::vector<CheckResult> rows;
  std::vector<Group> groups;

 private:
  static bool is_last(const Assessment& assessment, std::size_t c) {
    if (c + 1 == assessment.charts.size()) return true;
    const CheckResult &of = assessment.charts[c].of, &next = assessment.charts[c + 1].of;
    return next.kind != of.kind || next.axis != of.axis || next.plateau != of.plateau;
  }
  Group& group(const CheckResult& of) {
    for (Group& one : groups)
      if (one.kind == of.kind && one.axis == of.axis) return one;
    return groups.emplace_back(Group{of.kind, of.axis});
  }
};

/// Values of the compared results: a column for each compared run, in order.
struct ComparedRuns {
  MatrixXd values;
  std::vector<std::size_t> runs;  ///< index in the history
};

ComparedRuns collect(const Assessment& assessment, const Layout& layout) {
  std::size_t from = 0;  // the first run of the last level
  for (std::size_t r = 0; r + 1 < assessment.runs.size(); ++r)
    if (assessment.runs[r].explanation && !assessment.runs[r + 1].explanation) from = r + 1;
  if (assessment.runs.size() - from <= kFewestBefore) from = 0;
  ComparedRuns compared;
  for (std::size_t r = from; r < assessment.runs.size(); ++r) {
    if (assessment.runs[r].explanation) continue;
    VectorXd column(layout.size());
    for (Index i = 0; i < layout.size(); ++i) {
      const Chart& chart = assessment.charts[layout.charts[static_cast<std::size_t>(i)]];
      const double value = chart.points[r].value;
      column(i) = chart.scale == ChartScale::linear ? value : std::cbrt(value * value);
    }
    if (!column.allFinite()) continue;
    compared.values.conservativeResize(layout.size(), compared.values.cols() + 1);
    compared.values.rightCols(1) = column;
    compared.runs.push_back(r);
  }
  return compared;
}

/// Mean squares of the differences between successive runs, halved: a step between two runs hardly enlarges them
/// (moving range). `common` is the part that all members of a group share.
struct Components {
  double common{}, own{};
};

Components components(const MatrixXd& differences) {
  const auto runs = static_cast<double>(differences.cols()), members = static_cast<double>(differences.rows());
  const VectorXd means = differences.colwise().mean();
  const double of_means = means.squaredNorm() / (2 * runs);
  if (members < 2) return {0, of_means};
  const double own = (differences.rowwise() - means.transpose()).squaredNorm() / (2 * runs * (members - 1));
  return {std::max(0.0, of_means - own / members), own};
}

MatrixXd pick_rows(const MatrixXd& values, const std::vector<Index>& rows) {
  MatrixXd picked(std::ssize(rows), values.cols());
  for (Index i = 0; i < picked.rows(); ++i) picked.row(i) = values.row(rows[static_cast<std::size_t>(i)]);
  return picked;
}

/// Adds the covariance of the biases or the scatter of an axis from run to run.
void add_axis(const Layout& layout, const Group& group, const MatrixXd& differences, MatrixXd& covariance) {
  const Components found = components(pick_rows(differences, group.members));
  for (const Index i : group.members) {
    const double stated = group.kind == CheckKind::bias ? layout.rows[static_cast<std::size_t>(i)].u : 0;
    covariance(i, i) += std::max({found.own, stated * stated, kSmallestNoise * kSmallestNoise});
    for (const Index j : group.members) covariance(i, j) += found.common;
  }
}

/// Returns the covariance of two differences per variance of the readings of `count` independent thermometers.
double contrast(const CheckResult& a, const CheckResult& b, double count) {
  const double same = a.thermometer == b.thermometer ? 1 : 0;
  return (same - 1 / count) * count * count / ((count - 1) * (count - 1));
}

/// Adds the covariance of the thermometers of a unit: independent readings, each minus the mean of the others. The part
/// that a thermometer has in common on all plateaus is separated from the part of each plateau.
void add_thermometers(const Layout& layout, const Group& group, const MatrixXd& differences, MatrixXd& covariance) {
  const auto at = [&](Index i) -> const CheckResult& { return layout.rows[static_cast<std::size_t>(i)]; };
  double common = 0, own = 0, sets = 0, stated = kSmallestNoiseK;
  for (const Index first : group.members) {
    if (at(first).plateau != at(group.members.front()).plateau) continue;
    std::vector<Index> same;
    for (const Index i : group.members)
      if (at(i).thermometer == at(first).thermometer) same.push_back(i);
    const Components found = components(pick_rows(differences, same));
    common += found.common;
    own += found.own;
    sets += 1;
    stated = std::max(stated, at(first).u);
  }
  const double count = sets + 1;  // with the last thermometer
  const double to_reading = (count - 1) / count / sets;
  own = std::max(own * to_reading, stated * stated);
  common *= to_reading;
  for (const Index i : group.members)
    for (const Index j : group.members)
      covariance(i, j) += (common + (at(i).plateau == at(j).plateau ? own : 0)) * contrast(at(i), at(j), count);
}

/// Adds the covariance of the certified drift of all thermometers in a time: independent random walks.
void add_drift(const Layout& layout, const CheckEntry& check, double years, MatrixXd& covariance) {
  double squares = 0;
  for (const CheckedThermometer& one : check.thermometers) squares += one.drift_k_per_year * one.drift_k_per_year;
  const double variance = years * squares / std::max(1.0, static_cast<double>(check.thermometers.size()));
  for (const Group& group : layout.groups) {
    if (group.kind != CheckKind::thermometer) continue;
    const auto at = [&](Index i) -> const CheckResult& { return layout.rows[static_cast<std::size_t>(i)]; };
    const double count = 1 + static_cast<double>(std::ranges::count_if(group.members, [&](Index i) {
                           return at(i).plateau == at(group.members.front()).plateau;
                         }));
    for (const Index i : group.members)
      for (const Index j : group.members) covariance(i, j) += variance * contrast(at(i), at(j), count);
  }
}

MatrixXd covariance_of_run(const Layout& layout, const MatrixXd& values) {
  const Index last = values.cols() - 1;
  const MatrixXd differences = values.rightCols(last) - values.leftCols(last);
  MatrixXd covariance = MatrixXd::Zero(layout.size(), layout.size());
  for (const Group& group : layout.groups)
    if (group.kind == CheckKind::thermometer)
      add_thermometers(layout, group, differences, covariance);
    else
      add_axis(layout, group, differences, covariance);
  return covariance;
}

/// A change between runs, y with its covariance.
struct Change {
  VectorXd y;
  MatrixXd covariance;
  Eigen::LLT<MatrixXd> root;
  Eigen::LLT<MatrixXd> root_with_drift;  ///< root of the covariance with the drift of the thermometers
  std::size_t first_after{};             ///< column
};

Change change_at(const MatrixXd& values, const MatrixXd& covariance, std::size_t first_after) {
  const auto before = static_cast<Index>(first_after), after = values.cols() - before;
  Change change{.y = values.rightCols(after).rowwise().mean() - values.leftCols(before).rowwise().mean(),
                .covariance = covariance * (1 / static_cast<double>(before) + 1 / static_cast<double>(after)),
                .root = {},
                .root_with_drift = {},
                .first_after = first_after};
  change.root.compute(change.covariance);
  return change;
}

/// Finds the change with the greatest χ².
Change find_change(const MatrixXd& values, const MatrixXd& covariance) {
  const auto runs = static_cast<std::size_t>(values.cols());
  Change best;
  double greatest = -1;
  for (std::size_t after = 1; after <= std::min(kMostRunsSince, runs - kFewestBefore); ++after) {
    Change change = change_at(values, covariance, runs - after);
    const double chi_squared = change.y.dot(change.root.solve(change.y));
    if (chi_squared <= greatest) continue;
    greatest = chi_squared;
    best = std::move(change);
  }
  return best;
}

/// Patterns of a hypothesis; the amplitudes are independent with unit variance.
struct Pattern {
  Hypothesis of;
  double prior{};
  MatrixXd columns;
  double unit_amount = 1;  ///< amount per unit of the amplitudes
};

/// Collects the patterns of all hypotheses for a history.
class Patterns {
 public:
  Patterns(const History& history, const Layout& layout)
      : head_(history.head), check_(history.checks.back()), layout_(layout) {
    add_thermometer_patterns();
    add_mount();
    add_gyro();
    all_.push_back({{.cause = ChangeCause::false_alarm}, kFalseAlarmPrior, MatrixXd(layout.size(), 0)});
  }
  [[nodiscard]] std::vector<Pattern> take() && { return std::move(all_); }

 private:
  static constexpr double kFalseAlarmPrior = 0.1, kCausePrior = 0.3;

  [[nodiscard]] const CheckResult& row(Index i) const { return layout_.rows[static_cast<std::size_t>(i)]; }
  static double span(const CheckResult& of) { return (of.at_c - kReferenceC) / kSpanK; }

  [[nodiscard]] double thermometer_change(const std::string& name) const {
    const auto found = std::ranges::find(check_.thermometers, name, &CheckedThermometer::name);
    return std::max(kSmallestChangeK, found == check_.thermometers.end() ? 0 : 2 * found->u_k);
  }

  /// Returns the names of the thermometers of a unit, also of the last one.
  [[nodiscard]] std::vector<std::string> thermometers_of(const std::string& unit) const {
    std::vector<std::string> names;
    for (const CheckResult& result : check_.results)
      if (result.kind == CheckKind::thermometer && result.axis == unit &&
          std::ranges::count(names, result.thermometer) == 0)
        names.push_back(result.thermometer);
    return names;
  }

  void add_thermometer_patterns() {
    double count = 0;
    const std::size_t first = all_.size();
    for (const Group& group : layout_.groups) {
      if (group.kind != CheckKind::thermometer) continue;
      const auto names = thermometers_of(group.axis);
      const auto others = static_cast<double>(names.size() - 1);
      for (const std::string& name : names) {
        const double change = thermometer_change(name);
        Pattern pattern{{.cause = ChangeCause::thermometer, .part = name, .unit = "K"},
                        kCausePrior,
                        MatrixXd::Zero(layout_.size(), 2),
                        change};
        for (const Index i : group.members) {
          const double share = row(i).thermometer == name ? 1 : -1 / others;
          pattern.columns(i, 0) = change * share;
          pattern.columns(i, 1) = change / 2 * share * span(row(i));
        }
        all_.push_back(std::move(pattern));
        count += 1;
      }
    }
    for (std::size_t i = first; i < all_.size(); ++i) all_[i].prior /= count;
  }

  /// Covariance of the Earth rates on two axes for a small rotation of the mount of unit variance about each direction,
  /// in (°/h)²/rad²: (n_a × ω)·(n_b × ω) = (n_a·n_b) ω² − ω_a ω_b.
  [[nodiscard]] double tilt_covariance(const CheckedAxis& a, const CheckedAxis& b) const {
    double cosine = a.axis == b.axis ? 1 : 0;
    if (a.direction.size() == 3 && b.direction.size() == 3) {
      cosine = 0;
      for (std::size_t k = 0; k < 3; ++k) cosine += a.direction[k] * b.direction[k];
    } else if (a.axis != b.axis) {
      return 0;  // not on one fixture
    }
    return cosine * kEarthRate * kEarthRate - a.earth_rate_deg_per_h * b.earth_rate_deg_per_h;
  }

  void add_mount() {
    const Index axes = std::ssize(check_.axes);
    MatrixXd covariance(axes, axes);
    for (Index a = 0; a < axes; ++a)
      for (Index b = 0; b < axes; ++b)
        covariance(a, b) =
            tilt_covariance(check_.axes[static_cast<std::size_t>(a)], check_.axes[static_cast<std::size_t>(b)]);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(covariance);
    const double change = head_.mount_change_deg;
    Pattern pattern{
        {.cause = ChangeCause::mount, .unit = "°"}, kCausePrior, MatrixXd::Zero(layout_.size(), axes), change};
    Index used = 0;
    for (Index mode = 0; mode < axes; ++mode) {
      const double size = modes.eigenvalues()(mode);
      if (size < 1e-6 * kEarthRate * kEarthRate) continue;
      for (Index i = 0; i < layout_.size(); ++i) {
        if (row(i).kind != CheckKind::bias) continue;
        const auto axis = std::ranges::find(check_.axes, row(i).axis, &CheckedAxis::axis) - check_.axes.begin();
        pattern.columns(i, used) =
            (row(i).turned ? -1 : 1) * change * kDegree * std::sqrt(size) * modes.eigenvectors()(axis, mode);
      }
      ++used;
    }
    pattern.columns.conservativeResize(layout_.size(), used);
    if (used > 0) all_.push_back(std::move(pattern));
  }

  /// Returns the plausible change of a golden axis: as given, or twice the stated turn-on repeatability.
  [[nodiscard]] double gyro_change(const std::string& axis) const {
    constexpr double kDefault = 0.002;
    if (head_.gyro_change_deg_per_h > 0) return head_.gyro_change_deg_per_h;
    const auto found = std::ranges::find(check_.axes, axis, &CheckedAxis::axis);
    return found == check_.axes.end() || found->turn_on_deg_per_h <= 0 ? kDefault : 2 * found->turn_on_deg_per_h;
  }

  void add_gyro() {
    const double share = kCausePrior / static_cast<double>(check_.axes.size());
    for (const Group& group : layout_.groups) {
      if (group.kind == CheckKind::thermometer) continue;
      if (group.kind == CheckKind::scatter) {
        Pattern pattern{{.cause = ChangeCause::gyro, .part = group.axis + ", scatter", .unit = "°/h"},
                        share / 4,
                        MatrixXd::Zero(layout_.size(), 1),
                        0};
        for (const Index i : group.members) {
          pattern.unit_amount = kScatterChange * row(i).value;
          pattern.columns(i, 0) = 2.0 / 3 * kScatterChange * std::cbrt(row(i).value * row(i).value);
        }
        all_.push_back(std::move(pattern));
        continue;
      }
      add_bias_patterns(group, share);
    }
  }

  void add_bias_patterns(const Group& group, double share) {
    const double change = gyro_change(group.axis);
    Pattern constant{{.cause = ChangeCause::gyro, .part = group.axis + ", constant", .unit = "°/h"},
                     share / 2,
                     MatrixXd::Zero(layout_.size(), 1),
                     change};
    Pattern varying{{.cause = ChangeCause::gyro, .part = group.axis + ", with temperature", .unit = "°/h"},
                    share / 4,
                    MatrixXd::Zero(layout_.size(), 3),
                    change};
    for (const Index i : group.members) {
      const double t = span(row(i));
      constant.columns(i, 0) = change;
      varying.columns.row(i) << change * t, change, change * t * t;
    }
    all_.push_back(std::move(constant));
    all_.push_back(std::move(varying));
  }

  const HistoryHead& head_;
  const CheckEntry& check_;
  const Layout& layout_;
  std::vector<Pattern> all_;
};

/// Generalised least squares estimate of the amplitudes of a pattern.
struct Estimate {
  VectorXd amplitudes;
  MatrixXd covariance;
  double chi_squared{};  ///< the residual's chi-squared
};

Estimate estimate_amplitudes(const MatrixXd& columns, const VectorXd& y, const Eigen::LLT<MatrixXd>& root) {
  const double whole = y.dot(root.solve(y));
  if (columns.cols() == 0) return {{}, {}, whole};
  const MatrixXd weighted = root.solve(columns);
  const VectorXd projected = weighted.transpose() * y;
  MatrixXd inverse = (columns.transpose() * weighted).completeOrthogonalDecomposition().pseudoInverse();
  VectorXd amplitudes = inverse * projected;
  const double explained = amplitudes.dot(projected);
  return {std::move(amplitudes), std::move(inverse), std::max(0.0, whole - explained)};
}

/// Estimates the amount of a pattern, and the χ² of the residual.
void fit(Pattern& pattern, const Change& change) {
  Hypothesis& of = pattern.of;
  of.chi_squared = estimate_amplitudes(pattern.columns, change.y, change.root_with_drift).chi_squared;
  of.degrees = static_cast<double>(change.y.size() - pattern.columns.cols());
  of.fits = data::chi_squared_exceeds(of.chi_squared, std::max(1.0, of.degrees));
  of.amount = of.amount_u = std::numeric_limits<double>::quiet_NaN();
  if (pattern.columns.cols() == 0) return;
  const Estimate found = estimate_amplitudes(pattern.columns, change.y, change.root);
  const bool is_size = of.cause == ChangeCause::mount;
  const double variance =
      is_size ? found.covariance.trace() / static_cast<double>(found.amplitudes.size()) : found.covariance(0, 0);
  of.amount = pattern.unit_amount * (is_size ? found.amplitudes.norm() : found.amplitudes(0));
  of.amount_u = pattern.unit_amount * std::sqrt(variance);
}

/// Returns the logarithm of prior × density of y.
double log_weight(const Pattern& pattern, const Change& change) {
  const Eigen::LLT<MatrixXd> root(change.covariance + pattern.columns * pattern.columns.transpose());
  const VectorXd white = root.matrixL().solve(change.y);
  const double log_root = root.matrixLLT().diagonal().array().log().sum();
  return std::log(pattern.prior) - log_root - white.squaredNorm() / 2;
}

void compute_posteriors(std::vector<Pattern>& patterns, const Change& change) {
  std::vector<double> weights;
  for (const Pattern& pattern : patterns) weights.push_back(log_weight(pattern, change));
  const double greatest = *std::ranges::max_element(weights);
  double sum = 0;
  for (double& weight : weights) sum += weight = std::exp(weight - greatest);
  for (std::size_t i = 0; i < patterns.size(); ++i) patterns[i].of.posterior = weights[i] / sum;
}

void name_cause(Diagnosis& diagnosis) {
  for (const Hypothesis& one : diagnosis.hypotheses)
    diagnosis.probabilities[static_cast<std::size_t>(one.cause)] += one.posterior;
  const Hypothesis& best = diagnosis.hypotheses.front();
  const bool is_probable = diagnosis.probabilities[static_cast<std::size_t>(best.cause)] >= kNamed;
  if (is_probable && best.fits >= kFits) diagnosis.named = best.cause;
}

/// Returns the mean time between the runs before the change and since, in years.
double years_between(const History& history, const ComparedRuns& compared, std::size_t first_after) {
  constexpr double kDaysPerYear = 365.25;
  const auto mean_day = [&](std::size_t from, std::size_t to) {
    double sum = 0;
    for (std::size_t i = from; i < to; ++i) {
      const auto day = record::parse_day(history.checks[compared.runs[i]].started_utc.substr(0, 10));
      sum += day ? static_cast<double>(day->time_since_epoch().count()) : 0;
    }
    return sum / static_cast<double>(to - from);
  };
  return std::abs(mean_day(first_after, compared.runs.size()) - mean_day(0, first_after)) / kDaysPerYear;
}

bool has_equal_patterns(const CheckEntry& check) {
  const auto is_turned = [](const CheckResult& result) { return result.turned; };
  return check.axes.size() == 1 && std::ranges::none_of(check.results, is_turned);
}

}  // namespace

const char* name(ChangeCause cause) {
  return enumerator_text<ChangeCause::false_alarm>({"thermometer", "mount", "gyro", "false_alarm"}, cause);
}

std::optional<Diagnosis> diagnose(const History& history, const Assessment& assessment) {
  const Layout layout(assessment);
  const ComparedRuns compared = collect(assessment, layout);
  if (compared.runs.size() <= kFewestBefore) return {};
  Change change = find_change(compared.values, covariance_of_run(layout, compared.values));
  MatrixXd with_drift = change.covariance;
  add_drift(layout, history.checks.back(), years_between(history, compared, change.first_after), with_drift);
  change.root_with_drift.compute(with_drift);
  auto patterns = Patterns(history, layout).take();
  for (Pattern& pattern : patterns) fit(pattern, change);
  compute_posteriors(patterns, change);
  Diagnosis diagnosis{.since = compared.runs[change.first_after],
                      .before = change.first_after,
                      .after = compared.runs.size() - change.first_after,
                      .tilt_equals_drift = false};
  for (Pattern& pattern : patterns) diagnosis.hypotheses.push_back(std::move(pattern.of));
  std::ranges::stable_sort(diagnosis.hypotheses, std::ranges::greater{}, &Hypothesis::posterior);
  name_cause(diagnosis);
  const double of_bias = diagnosis.probabilities[static_cast<std::size_t>(ChangeCause::mount)] +
                         diagnosis.probabilities[static_cast<std::size_t>(ChangeCause::gyro)];
  constexpr double kRelevant = 0.05;
  diagnosis.tilt_equals_drift = of_bias > kRelevant && has_equal_patterns(history.checks.back());
  return diagnosis;
}

}  // namespace gyrotherm::assurance
