#include "analysis/data/allan_fit.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "analysis/data/allan_covariance.hpp"
#include "core/quantity.hpp"

namespace gyrotherm {
namespace {

constexpr double kArcsecPerDegree = 3600;
constexpr double kSignificance = 2;  // of a square, in its standard errors
constexpr double kOneSided95 = 1.645;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

const std::array<NoiseTermInfo, kNoiseTerms> kInfo = {{
    {"Q", "quantisation", "arcsec", "√3·Q/τ", 1.7320508075688772 * kSecondsPerHour},
    {"N", "angle random walk", "°/√h", "N/√τ", kSecondsPerHour},
    {"B", "bias instability", "°/h", "0.664·B", kNone},
    {"K", "rate random walk", "°/h/√h", "K·√(τ/3)", 3 * kSecondsPerHour},
    {"R", "rate ramp", "°/h²", "R·τ/√2", 1.4142135623730951 * kSecondsPerHour},
}};

/// Which terms are fitted, in the order of NoiseTerm.
using Terms = std::vector<Eigen::Index>;

struct Fitted {
  Terms terms;
  NoiseSquares squares = NoiseSquares::Zero();
  NoiseSquares errors = NoiseSquares::Zero();  ///< standard errors of the squares of `terms`
};

/// Values of the given terms, zeros elsewhere.
NoiseSquares spread_over(const Terms& terms, const Eigen::VectorXd& values) {
  NoiseSquares all = NoiseSquares::Zero();
  for (std::size_t k = 0; k < terms.size(); ++k) all(terms[k]) = values(static_cast<Eigen::Index>(k));
  return all;
}

/// The curve as a problem of least squares.
struct Problem {
  const AllanCurve& curve;
  const RateStretches& rates;
  Eigen::VectorXd variances;
  Eigen::MatrixXd shapes;           ///< points × terms
  Eigen::VectorXd relative_errors;  ///< of the variances, by sampling
  double misfit{};                  ///< of the variances beside that, relative, each point on its own
};

Problem problem_of(const AllanCurve& curve, const RateStretches& rates) {
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

/// Least squares of variances on the given terms with these weights.
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
  /// The linear map from variances to squares that solve() is.
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

/// Least squares with no square negative: of all subsets of the terms whose own solution is positive, the one that is
/// left with the least. Five terms have 32 subsets, so none need be guessed.
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
    best = spread_over(chosen, squares);
  }
  return best;
}

/// The variances of `squares`, or measured ones where these give none; above 0.
Eigen::VectorXd variances_about(const Problem& problem, const NoiseSquares& squares) {
  Eigen::VectorXd about = problem.shapes * squares;
  const double least = std::max(1e-12 * problem.variances.maxCoeff(), std::numeric_limits<double>::min());
  for (Eigen::Index k = 0; k < about.size(); ++k) {
    if (!(about(k) > 0)) about(k) = problem.variances(k);
    about(k) = std::max(about(k), least);
  }
  return about;
}

Eigen::VectorXd weights_about(const Problem& problem, const NoiseSquares& squares) {
  const auto relative = (problem.relative_errors.array().square() + problem.misfit * problem.misfit).sqrt();
  return (relative * variances_about(problem, squares).array()).inverse();
}

Fitted fit_terms(const Problem& problem, const Terms& terms) {
  constexpr int kPasses = 8;
  Fitted fitted{.terms = terms};
  for (int pass = 0; pass < kPasses; ++pass) {
    fitted.squares = non_negative(problem, terms, weights_about(problem, fitted.squares));
  }
  std::erase_if(fitted.terms, [&](Eigen::Index term) { return fitted.squares(term) == 0; });
  return fitted;
}

/// Covariance of the variances: sampling, and the misfit of each point.
Eigen::MatrixXd covariance_about(const Problem& problem, const NoiseSquares& squares) {
  Eigen::MatrixXd covariance = allan_covariance(problem.curve, problem.rates, squares);
  covariance.diagonal() += (problem.misfit * variances_about(problem, squares)).cwiseAbs2();
  return covariance;
}

/// Σ of the squared residuals in their errors, of the best fit.
double chi_squared(const Problem& problem, const Terms& terms) {
  const Fitted fitted = fit_terms(problem, terms);
  const Eigen::VectorXd left = problem.variances - problem.shapes * fitted.squares;
  return left.cwiseProduct(weights_about(problem, fitted.squares)).squaredNorm();
}

/// Errors by the fitted noise instead of 1/√(2(K − 1)); then, if χ² is greater than chance makes it, the misfit at
/// which it is f, the number of points less that of terms (Mandel and Paule 1970).
void estimate_errors(Problem& problem, const Terms& terms) {
  const Fitted first = fit_terms(problem, terms);
  const Eigen::VectorXd sampling = covariance_about(problem, first.squares).diagonal().cwiseSqrt();
  const Eigen::VectorXd relative = sampling.cwiseQuotient(variances_about(problem, first.squares));
  if (!(relative.minCoeff() > 0)) return;
  problem.relative_errors = relative;
  const double freedom = static_cast<double>(problem.curve.size()) - static_cast<double>(terms.size());
  constexpr double kChance = 3;  // standard deviations of χ², √(2f) each
  if (freedom <= 0 || chi_squared(problem, terms) <= freedom + kChance * std::sqrt(2 * freedom)) return;
  constexpr int kHalvings = 14;
  double low = 0, high = 1;
  for (int k = 0; k < kHalvings; ++k) {
    problem.misfit = (low + high) / 2;
    (chi_squared(problem, terms) > freedom ? low : high) = problem.misfit;
  }
}

/// Standard errors of the squares when just these terms are fitted.
Eigen::VectorXd errors_of(const Problem& problem, const Terms& terms, const Fitted& about,
                          const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd map = LeastSquares(problem, terms, weights_about(problem, about.squares)).map();
  return (map * covariance * map.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
}

/// Terms leave one by one, the least certain first, until each that is left is seen.
Fitted fit_seen(const Problem& problem, Terms terms) {
  while (true) {
    Fitted fitted = fit_terms(problem, terms);
    if (fitted.terms.empty()) return fitted;
    const Eigen::MatrixXd covariance = covariance_about(problem, fitted.squares);
    fitted.errors = spread_over(fitted.terms, errors_of(problem, fitted.terms, fitted, covariance));
    const auto certainty = [&](Eigen::Index term) { return fitted.squares(term) / fitted.errors(term); };
    const auto weakest = std::ranges::min_element(fitted.terms, {}, certainty);
    if (fitted.terms.size() == 1 || certainty(*weakest) >= kSignificance) return fitted;
    terms = fitted.terms;
    std::erase(terms, *weakest);
  }
}

/// The upper limit of a square: fitted once more beside the terms that are seen.
double limit_of(const Problem& problem, const Fitted& fitted, Eigen::Index term, const Eigen::MatrixXd& covariance) {
  Terms with = fitted.terms;
  if (std::ranges::count(with, term) == 0) with.push_back(term);
  if (with.size() > problem.curve.size()) return kNone;
  const auto place = std::ranges::find(with, term) - with.begin();
  const LeastSquares fit(problem, with, weights_about(problem, fitted.squares));
  const double square = std::max(0.0, fit.solve(problem.variances)(place));
  return square + kOneSided95 * errors_of(problem, with, fitted, covariance)(place);
}

double unit_of(NoiseTerm term) { return term == NoiseTerm::quantisation ? kArcsecPerDegree : 1; }

NoiseCoefficient coefficient_of(const Problem& problem, const Fitted& fitted, NoiseTerm term,
                                const Eigen::MatrixXd& covariance) {
  const auto index = static_cast<Eigen::Index>(term);
  NoiseCoefficient coefficient{.term = term};
  coefficient.at_most = unit_of(term) * std::sqrt(limit_of(problem, fitted, index, covariance));
  const double square = fitted.squares(index);
  coefficient.seen = square > 0 && square >= kSignificance * fitted.errors(index);
  if (!coefficient.seen) return coefficient;
  coefficient.value = unit_of(term) * std::sqrt(square);
  coefficient.error = unit_of(term) * fitted.errors(index) / (2 * std::sqrt(square));
  return coefficient;
}

}  // namespace

const NoiseTermInfo& info(NoiseTerm term) { return kInfo[static_cast<std::size_t>(term)]; }

const NoiseCoefficient& of(const AllanFit& fit, NoiseTerm term) {
  return fit.coefficients[static_cast<std::size_t>(term)];
}

double deviation_of(const NoiseCoefficient& coefficient, double tau_s) {
  const double shape = noise_shapes(tau_s / kSecondsPerHour)(static_cast<Eigen::Index>(coefficient.term));
  return coefficient.value / unit_of(coefficient.term) * std::sqrt(shape);
}

double deviation_of(const AllanFit& fit, double tau_s) {
  double variance = 0;
  for (const NoiseCoefficient& coefficient : fit.coefficients) {
    variance += std::pow(deviation_of(coefficient, tau_s), 2);
  }
  return std::sqrt(variance);
}

AllanFit fit_allan(const AllanCurve& curve, const RateStretches& rates) {
  assert(!curve.empty());
  Problem problem = problem_of(curve, rates);
  constexpr std::array<Eigen::Index, kNoiseTerms> kByTau = {1, 0, 3, 2, 4};
  Terms terms(kByTau.begin(), kByTau.begin() + static_cast<std::ptrdiff_t>(std::min(kNoiseTerms, curve.size())));
  std::ranges::sort(terms);
  estimate_errors(problem, terms);
  const Fitted fitted = fit_seen(problem, terms);
  const Eigen::MatrixXd covariance = covariance_about(problem, fitted.squares);
  AllanFit fit;
  fit.misfit = problem.misfit / 2;
  for (std::size_t k = 0; k < kNoiseTerms; ++k) {
    fit.coefficients[k] = coefficient_of(problem, fitted, static_cast<NoiseTerm>(k), covariance);
  }
  const auto lowest =
      std::ranges::min_element(curve, {}, [&](const AllanPoint& point) { return deviation_of(fit, point.tau_s); });
  fit.lowest_tau_s = lowest->tau_s;
  return fit;
}

}  // namespace gyrotherm
