// SPDX-License-Identifier: Apache-2.0
#include "analysis/data/allan.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "core/quantity.hpp"

namespace gyrotherm::data {
namespace {

/// Returns θ of NIST SP 1065, the running sum. It has one element more than `values`.
Eigen::VectorXd running_sum(const Eigen::Ref<const Eigen::VectorXd>& values) {
  Eigen::VectorXd sum(values.size() + 1);
  sum(0) = 0;
  for (Eigen::Index i = 0; i < values.size(); ++i) sum(i + 1) = sum(i) + values(i);
  return sum;
}

struct SquareSum {
  double sum{};
  int count{};
};

SquareSum squared_differences(const Eigen::VectorXd& theta, Eigen::Index m) {
  const Eigen::Index count = theta.size() - 2 * m;
  if (count < 1) return {};
  const auto second_difference = theta.tail(count) - 2 * theta.segment(m, count) + theta.head(count);
  return {second_difference.squaredNorm(), static_cast<int>(count)};
}

double noise_deviation(const SquareSum& squares, double m) { return std::sqrt(squares.sum / squares.count / 2) / m; }

/// Counts the independent differences: Σ(K − 1) over the stretches, where K is the number of means of m samples in a
/// stretch.
int independent_differences(const RateStretches& rates, Eigen::Index m) {
  int count = 0;
  for (const Eigen::VectorXd& stretch : rates.values) {
    if (stretch.size() >= 2 * m) count += static_cast<int>(stretch.size() / m - 1);
  }
  return count;
}

/// Returns the generalised covariance g of the angle at lags of 0, 1, 2, … intervals.
std::vector<double> generalised_covariance(const NoiseSquares& squares, double interval_h, Eigen::Index lags) {
  std::vector<double> g(static_cast<std::size_t>(lags) + 1);
  g[0] = squares(0);
  for (std::size_t lag = 1; lag < g.size(); ++lag) {
    const double t = static_cast<double>(lag) * interval_h;
    g[lag] =
        -0.5 * squares(1) * t + squares(2) * t * t * std::log(t) / (2 * std::numbers::pi) + squares(3) * t * t * t / 12;
  }
  return g;
}

/// Computes the covariance of two second differences of the angle. The difference over `m` samples starts `lag` samples
/// after the difference over `n` samples.
double covariance_at(const std::vector<double>& g, Eigen::Index lag, Eigen::Index m, Eigen::Index n) {
  constexpr double kWeights[] = {1, -2, 1};
  double sum = 0;
  for (Eigen::Index a = 0; a < 3; ++a) {
    for (Eigen::Index b = 0; b < 3; ++b) {
      sum += kWeights[a] * kWeights[b] * g[static_cast<std::size_t>(std::abs(lag + a * m - b * n))];
    }
  }
  return sum;
}

/// Number of stretches of each length.
using Lengths = std::map<Eigen::Index, double>;

Lengths count_lengths(const RateStretches& rates) {
  Lengths lengths;
  for (const Eigen::VectorXd& stretch : rates.values) ++lengths[stretch.size()];
  return lengths;
}

/// Counts the pairs of differences in one stretch, over m samples from i and over n samples from j, with i − j = lag.
double count_pairs(const Lengths& lengths, Eigen::Index lag, Eigen::Index m, Eigen::Index n) {
  double pairs = 0;
  for (const auto& [length, count] : lengths) {
    const Eigen::Index count_m = length + 1 - 2 * m, count_n = length + 1 - 2 * n;
    if (count_m < 1 || count_n < 1) continue;
    pairs += count * static_cast<double>(
                         std::max<Eigen::Index>(0, std::min(count_m, count_n + lag) - std::max<Eigen::Index>(0, lag)));
  }
  return pairs;
}

constexpr double kArcsecPerDegree = 3600;
// Significance threshold for a square, in standard errors.
constexpr double kSignificance = 2;
constexpr double kOneSided95 = 1.645;
constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();

const std::array<NoiseTermInfo, kNoiseTerms> kInfo = {{
    {"Q", "quantisation", "arcsec", "√3·Q/τ", 1.7320508075688772 * kSecondsPerHour},
    {"N", "angle random walk", "°/√h", "N/√τ", kSecondsPerHour},
    {"B", "bias instability", "°/h", "0.664·B", kNoTime},
    {"K", "rate random walk", "°/h/√h", "K·√(τ/3)", 3 * kSecondsPerHour},
    {"R", "rate ramp", "°/h²", "R·τ/√2", 1.4142135623730951 * kSecondsPerHour},
}};

/// Indices of the fitted terms, in the order of NoiseTerm.
using Terms = std::vector<Eigen::Index>;

struct Fitted {
  Terms terms;
  NoiseSquares squares = NoiseSquares::Zero();
  /// Standard errors of the squares of `terms`.
  NoiseSquares errors = NoiseSquares::Zero();
};

/// Returns `values` at the indices of `terms` and zero elsewhere.
NoiseSquares expand_terms(const Terms& terms, const Eigen::VectorXd& values) {
  NoiseSquares all = NoiseSquares::Zero();
  for (std::size_t k = 0; k < terms.size(); ++k) all(terms[k]) = values(static_cast<Eigen::Index>(k));
  return all;
}

/// Least-squares problem for the fit to a curve.
struct Problem {
  const AllanCurve& curve;
  const RateStretches& rates;
  Eigen::VectorXd variances;
  Eigen::MatrixXd shapes;  ///< points × terms
  /// Relative sampling errors of the variances.
  Eigen::VectorXd relative_errors;
  /// Additional relative error of each variance, independent between points.
  double misfit{};
};

Problem make_problem(const AllanCurve& curve, const RateStretches& rates) {
  const auto points = static_cast<Eigen::Index>(curve.size());
  Problem problem{curve, rates, Eigen::VectorXd(points), Eigen::MatrixXd(points, kNoiseTerms), Eigen::VectorXd(points)};
  for (Eigen::Index k = 0; k < points; ++k) {
    const AllanPoint& point = curve[k];
    problem.variances(k) = point.deviation_deg_per_h * point.deviation_deg_per_h;
    problem.shapes.row(k) = noise_shapes(point.tau_s / kSecondsPerHour).transpose();
    const bool any = point.deviation_deg_per_h > 0;
    problem.relative_errors(k) = any ? 2 * point.error_deg_per_h / point.deviation_deg_per_h : 1;
  }
  return problem;
}

/// Weighted least-squares fit of the given terms to the variances.
class LeastSquares {
 public:
  LeastSquares(const Problem& problem, const Terms& terms, Eigen::VectorXd weights) : weights_(std::move(weights)) {
    const Eigen::MatrixXd design = weights_.asDiagonal() * problem.shapes(Eigen::all, terms);
    scale_ = design.colwise().norm().transpose();
    qr_.compute(design * scale_.cwiseInverse().asDiagonal());
  }
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& variances) const {
    const Eigen::VectorXd weighted = weights_.cwiseProduct(variances);
    const Eigen::VectorXd scaled = qr_.solve(weighted);
    return scaled.cwiseQuotient(scale_);
  }
  /// Returns the matrix of the linear map that solve() applies, from variances to squares.
  [[nodiscard]] Eigen::MatrixXd map() const {
    Eigen::MatrixXd columns(scale_.size(), weights_.size());
    for (Eigen::Index k = 0; k < weights_.size(); ++k)
      columns.col(k) = solve(Eigen::VectorXd::Unit(weights_.size(), k));
    return columns;
  }

 private:
  Eigen::VectorXd weights_, scale_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
};

/// Solves the least squares problem with non-negative squares. Tries all subsets of the terms (at most 32) and returns
/// the non-negative solution with the smallest loss.
NoiseSquares non_negative(const Problem& problem, const Terms& terms, const Eigen::VectorXd& weights) {
  NoiseSquares best = NoiseSquares::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (unsigned subset = 1; subset < (1U << terms.size()); ++subset) {
    Terms chosen;
    for (std::size_t k = 0; k < terms.size(); ++k) {
      if ((subset >> k & 1U) != 0) chosen.push_back(terms[k]);
    }
    const Eigen::VectorXd squares = LeastSquares(problem, chosen, weights).solve(problem.variances);
    if (!(squares.minCoeff() >= 0)) continue;
    const Eigen::VectorXd left = problem.variances - problem.shapes(Eigen::all, chosen) * squares;
    const double loss = left.cwiseProduct(weights).squaredNorm();
    if (loss >= least) continue;
    least = loss;
    best = expand_terms(chosen, squares);
  }
  return best;
}

/// Returns the variances that `squares` predict, or the measured ones where the prediction is not positive. All are
/// above 0.
Eigen::VectorXd variances_about(const Problem& problem, const NoiseSquares& squares) {
  Eigen::VectorXd about = problem.shapes * squares;
  const double least = std::max(1e-12 * problem.variances.maxCoeff(), std::numeric_limits<double>::min());
  for (Eigen::Index k = 0; k < about.size(); ++k) {
    if (!(about(k) > 0)) about(k) = problem.variances(k);
    about(k) = std::max(about(k), least);
  }
  return about;
}

Eigen::VectorXd compute_weights(const Problem& problem, const NoiseSquares& squares) {
  const auto relative = (problem.relative_errors.array().square() + problem.misfit * problem.misfit).sqrt();
  return (relative * variances_about(problem, squares).array()).inverse();
}

Fitted fit_terms(const Problem& problem, const Terms& terms) {
  constexpr int kPasses = 8;
  Fitted fitted{.terms = terms};
  for (int pass = 0; pass < kPasses; ++pass) {
    fitted.squares = non_negative(problem, terms, compute_weights(problem, fitted.squares));
  }
  std::erase_if(fitted.terms, [&](Eigen::Index term) { return fitted.squares(term) == 0; });
  return fitted;
}

/// Computes the covariance of the Allan variances, including the misfit of each point.
Eigen::MatrixXd compute_covariance(const Problem& problem, const NoiseSquares& squares) {
  Eigen::MatrixXd covariance = allan_covariance(problem.curve, problem.rates, squares);
  covariance.diagonal() += (problem.misfit * variances_about(problem, squares)).cwiseAbs2();
  return covariance;
}

/// Computes χ² of the best fit: the sum of the squared residuals, each divided by its variance.
double chi_squared(const Problem& problem, const Terms& terms) {
  const Fitted fitted = fit_terms(problem, terms);
  const Eigen::VectorXd left = problem.variances - problem.shapes * fitted.squares;
  return left.cwiseProduct(compute_weights(problem, fitted.squares)).squaredNorm();
}

/// Replaces the errors 1/√(2(K − 1)) by the errors that follow from the fitted noise. If χ² is then larger than chance
/// allows, sets the misfit at which χ² equals f, the number of points minus the number of terms (Mandel and Paule
/// 1970).
void estimate_errors(Problem& problem, const Terms& terms) {
  const Fitted first = fit_terms(problem, terms);
  const Eigen::VectorXd sampling = compute_covariance(problem, first.squares).diagonal().cwiseSqrt();
  const Eigen::VectorXd relative = sampling.cwiseQuotient(variances_about(problem, first.squares));
  if (!(relative.minCoeff() > 0)) return;
  problem.relative_errors = relative;
  const double freedom = static_cast<double>(problem.curve.size()) - static_cast<double>(terms.size());
  // Limit in standard deviations of χ². One standard deviation is √(2f).
  constexpr double kSigmas = 3;
  if (freedom <= 0 || chi_squared(problem, terms) <= freedom + kSigmas * std::sqrt(2 * freedom)) return;
  constexpr int kHalvings = 14;
  double low = 0, high = 1;
  for (int k = 0; k < kHalvings; ++k) {
    problem.misfit = (low + high) / 2;
    (chi_squared(problem, terms) > freedom ? low : high) = problem.misfit;
  }
}

/// Computes the standard errors of the squares for a fit of exactly these terms.
Eigen::VectorXd standard_errors(const Problem& problem, const Terms& terms, const Fitted& about,
                                const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd map = LeastSquares(problem, terms, compute_weights(problem, about.squares)).map();
  return (map * covariance * map.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
}

/// Removes the least certain term until every remaining term is significant or only one term remains.
Fitted fit_significant(const Problem& problem, Terms terms) {
  while (true) {
    Fitted fitted = fit_terms(problem, terms);
    if (fitted.terms.empty()) return fitted;
    const Eigen::MatrixXd covariance = compute_covariance(problem, fitted.squares);
    fitted.errors = expand_terms(fitted.terms, standard_errors(problem, fitted.terms, fitted, covariance));
    const auto certainty = [&](Eigen::Index term) { return fitted.squares(term) / fitted.errors(term); };
    const auto weakest = std::ranges::min_element(fitted.terms, {}, certainty);
    if (fitted.terms.size() == 1 || certainty(*weakest) >= kSignificance) return fitted;
    terms = fitted.terms;
    std::erase(terms, *weakest);
  }
}

/// Square of a coefficient and its standard error.
struct Square {
  double value{}, error{};
};

/// Fits `term` together with the significant terms and returns its square. Returns nothing if the curve has too few
/// points.
std::optional<Square> refit_with_term(const Problem& problem, const Fitted& fitted, Eigen::Index term,
                                      const Eigen::MatrixXd& covariance) {
  Terms with = fitted.terms;
  if (std::ranges::count(with, term) == 0) with.push_back(term);
  if (with.size() > problem.curve.size()) return std::nullopt;
  const auto position = std::ranges::find(with, term) - with.begin();
  const LeastSquares fit(problem, with, compute_weights(problem, fitted.squares));
  return Square{std::max(0.0, fit.solve(problem.variances)(position)),
                standard_errors(problem, with, fitted, covariance)(position)};
}

double unit_factor(NoiseTerm term) { return term == NoiseTerm::quantisation ? kArcsecPerDegree : 1; }

NoiseCoefficient make_coefficient(const Problem& problem, const Fitted& fitted, NoiseTerm term,
                                  const Eigen::MatrixXd& covariance) {
  const auto index = static_cast<Eigen::Index>(term);
  NoiseCoefficient coefficient{.term = term};
  const double per_unit = std::pow(unit_factor(term), 2);
  if (const auto again = refit_with_term(problem, fitted, index, covariance)) {
    coefficient.at_most = unit_factor(term) * std::sqrt(again->value + kOneSided95 * again->error);
    coefficient.square = per_unit * again->value;
    coefficient.square_error = per_unit * again->error;
  } else {
    coefficient.at_most = coefficient.square = coefficient.square_error = kNoTime;
  }
  const double square = fitted.squares(index);
  coefficient.seen = square > 0 && square >= kSignificance * fitted.errors(index);
  if (!coefficient.seen) return coefficient;
  coefficient.value = unit_factor(term) * std::sqrt(square);
  coefficient.error = unit_factor(term) * fitted.errors(index) / (2 * std::sqrt(square));
  coefficient.square = per_unit * square;
  coefficient.square_error = per_unit * fitted.errors(index);
  return coefficient;
}

}  // namespace

RateStretches cut_at_gaps(const Eigen::Ref<const Eigen::VectorXd>& time_s,
                          const Eigen::Ref<const Eigen::VectorXd>& rate_deg_per_h, double interval_s) {
  assert(time_s.size() == rate_deg_per_h.size() && interval_s > 0);
  RateStretches rates{.interval_s = interval_s, .values = {}};
  Eigen::Index first = 0;
  for (Eigen::Index k = 0; k <= time_s.size(); ++k) {
    const bool known = k < time_s.size() && std::isfinite(rate_deg_per_h(k));
    const bool continues = known && (k == first || std::abs(time_s(k) - time_s(k - 1) - interval_s) < 0.5 * interval_s);
    if (continues) continue;
    if (k > first) rates.values.emplace_back(rate_deg_per_h.segment(first, k - first));
    first = known ? k : k + 1;
  }
  return rates;
}

AllanPoint allan_point(const RateStretches& rates, int m) {
  assert(m >= 1);
  const int independent = independent_differences(rates, m);
  SquareSum all;
  for (const Eigen::VectorXd& stretch : rates.values) {
    const SquareSum of = squared_differences(running_sum(stretch), m);
    all = {all.sum + of.sum, all.count + of.count};
  }
  const double deviation = noise_deviation(all, m);
  return {.m = m,
          .tau_s = m * rates.interval_s,
          .deviation_deg_per_h = deviation,
          .error_deg_per_h = deviation / std::sqrt(2.0 * independent),
          .differences = all.count};
}

AllanCurve allan_curve(const RateStretches& rates) {
  constexpr int kLeastDifferences = 2;
  AllanCurve curve;
  for (int m = 1; independent_differences(rates, m) >= kLeastDifferences; m *= 2) {
    curve.push_back(allan_point(rates, m));
  }
  return curve;
}

NoiseSquares noise_shapes(double tau_h) {
  return NoiseSquares{3 / (tau_h * tau_h), 1 / tau_h, 2 * std::numbers::ln2 / std::numbers::pi, tau_h / 3,
                      tau_h * tau_h / 2};
}

Eigen::MatrixXd allan_covariance(const AllanCurve& curve, const RateStretches& rates, const NoiseSquares& squares) {
  const double interval_h = rates.interval_s / kSecondsPerHour;
  const Lengths lengths = count_lengths(rates);
  const auto points = static_cast<Eigen::Index>(curve.size());
  // At lags above four times the longer averaging time only differences of bias instability are still correlated, and
  // their squared covariance is negligible.
  constexpr Eigen::Index kMaxLagFactor = 4;
  const Eigen::Index longest = points > 0 ? curve.back().m : 1;
  const std::vector<double> g = generalised_covariance(squares, interval_h, (kMaxLagFactor + 2) * longest);
  Eigen::MatrixXd covariance(points, points);
  for (Eigen::Index p = 0; p < points; ++p) {
    for (Eigen::Index q = 0; q <= p; ++q) {
      const Eigen::Index m = curve[p].m, n = curve[q].m;
      const double tau_m = static_cast<double>(m) * interval_h, tau_n = static_cast<double>(n) * interval_h;
      const double means = squares(4) * tau_m * tau_m * tau_n * tau_n;
      double sum = 0;
      for (Eigen::Index lag = -kMaxLagFactor * m; lag <= kMaxLagFactor * m; ++lag) {
        const double pairs = count_pairs(lengths, lag, m, n);
        if (pairs == 0) continue;
        const double c = covariance_at(g, lag, m, n);
        sum += pairs * (2 * c * c + 4 * means * c);
      }
      const double differences = static_cast<double>(curve[p].differences) * curve[q].differences;
      const double scale = 4 * tau_m * tau_m * tau_n * tau_n;
      covariance(p, q) = covariance(q, p) = sum / differences / scale;
    }
  }
  return covariance;
}

const NoiseTermInfo& info(NoiseTerm term) { return kInfo[static_cast<std::size_t>(term)]; }

std::array<NoiseCoefficient, kNoiseTerms> no_significant_terms() {
  std::array<NoiseCoefficient, kNoiseTerms> coefficients;
  for (std::size_t k = 0; k < kNoiseTerms; ++k)
    coefficients[k] = {.term = static_cast<NoiseTerm>(k), .at_most = std::numeric_limits<double>::quiet_NaN()};
  return coefficients;
}

NoiseCoefficient estimate_from_square(const NoiseCoefficient& coefficient) {
  NoiseCoefficient estimate = coefficient;
  const bool is_known = std::isfinite(coefficient.square) && coefficient.square > 0;
  estimate.value = is_known ? std::sqrt(coefficient.square) : 0;
  estimate.error = is_known ? coefficient.square_error / (2 * estimate.value) : 0;
  return estimate;
}

const NoiseCoefficient& find_coefficient(const AllanFit& fit, NoiseTerm term) {
  return fit.coefficients[static_cast<std::size_t>(term)];
}

double noise_deviation(const NoiseCoefficient& coefficient, double tau_s) {
  const double shape = noise_shapes(tau_s / kSecondsPerHour)(static_cast<Eigen::Index>(coefficient.term));
  return coefficient.value / unit_factor(coefficient.term) * std::sqrt(shape);
}

double noise_deviation(const AllanFit& fit, double tau_s) {
  double variance = 0;
  for (const NoiseCoefficient& coefficient : fit.coefficients) {
    variance += std::pow(noise_deviation(coefficient, tau_s), 2);
  }
  return std::sqrt(variance);
}

AllanFit fit_allan(const AllanCurve& curve, const RateStretches& rates) {
  constexpr std::array kByTau = {NoiseTerm::angle_random_walk, NoiseTerm::quantisation, NoiseTerm::rate_random_walk,
                                 NoiseTerm::bias_instability, NoiseTerm::rate_ramp};
  const auto count = static_cast<std::ptrdiff_t>(std::min(kNoiseTerms, curve.size()));
  return fit_allan(curve, rates, {kByTau.begin(), kByTau.begin() + count});
}

AllanFit fit_allan(const AllanCurve& curve, const RateStretches& rates, const std::vector<NoiseTerm>& of) {
  assert(!of.empty() && of.size() <= curve.size());
  Problem problem = make_problem(curve, rates);
  Terms terms;
  for (const NoiseTerm term : of) terms.push_back(static_cast<Eigen::Index>(term));
  std::ranges::sort(terms);
  estimate_errors(problem, terms);
  const Fitted fitted = fit_significant(problem, terms);
  const Eigen::MatrixXd covariance = compute_covariance(problem, fitted.squares);
  AllanFit fit;
  fit.misfit = problem.misfit / 2;
  for (std::size_t k = 0; k < kNoiseTerms; ++k) {
    fit.coefficients[k] = make_coefficient(problem, fitted, static_cast<NoiseTerm>(k), covariance);
  }
  const auto lowest =
      std::ranges::min_element(curve, {}, [&](const AllanPoint& point) { return noise_deviation(fit, point.tau_s); });
  fit.lowest_tau_s = lowest->tau_s;
  return fit;
}

}  // namespace gyrotherm::data
