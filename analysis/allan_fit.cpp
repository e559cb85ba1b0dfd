#include "analysis/allan_fit.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/allan_covariance.hpp"

namespace gyrotherm {
namespace {

constexpr double kSecondsPerHour = 3600;
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

/// The curve as a problem of least squares: measured variances, shapes, and the relative errors of the variances.
struct Problem {
  const AllanCurve& curve;
  const RateStretches& rates;
  Eigen::VectorXd variances;
  Eigen::MatrixXd shapes;  ///< points × terms
  Eigen::VectorXd relative_errors;
};

Problem problem_of(const AllanCurve& curve, const RateStretches& rates) {
  const auto points = static_cast<Eigen::Index>(curve.size());
  Problem problem{curve, rates, Eigen::VectorXd(points), Eigen::MatrixXd(points, kNoiseTerms), Eigen::VectorXd(points)};
  for (Eigen::Index k = 0; k < points; ++k) {
    const AllanPoint& point = curve[k];
    problem.variances(k) = point.deviation_deg_per_h * point.deviation_deg_per_h;
    problem.shapes.row(k) = noise_shapes(point.tau_s / kSecondsPerHour).transpose();
    problem.relative_errors(k) = point.deviation_deg_per_h > 0 ? point.error_deg_per_h / point.deviation_deg_per_h : 1;
  }
  return problem;
}

/// The linear map from variances to squares of the given terms: least squares with these weights.
Eigen::MatrixXd estimator(const Problem& problem, const Terms& terms, const Eigen::VectorXd& weights) {
  Eigen::MatrixXd design = weights.asDiagonal() * problem.shapes(Eigen::all, terms);
  const Eigen::RowVectorXd scale = design.colwise().norm();
  design = design * scale.cwiseInverse().asDiagonal();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
  Eigen::MatrixXd inverse(design.cols(), design.rows());
  for (Eigen::Index k = 0; k < design.rows(); ++k) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(design.rows(), k);
    inverse.col(k) = qr.solve(unit);
  }
  return scale.cwiseInverse().asDiagonal() * inverse * weights.asDiagonal();
}

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
    const Eigen::VectorXd squares = estimator(problem, chosen, weights) * problem.variances;
    if (!(squares.minCoeff() >= 0)) continue;
    const Eigen::VectorXd left = problem.variances - problem.shapes(Eigen::all, chosen) * squares;
    const double loss = left.cwiseProduct(weights).squaredNorm();
    if (loss >= least) continue;
    least = loss;
    best = spread_over(chosen, squares);
  }
  return best;
}

/// 1/(relative error × variance), the variances those of `squares`, or measured ones where these give none.
Eigen::VectorXd weights_about(const Problem& problem, const NoiseSquares& squares) {
  Eigen::VectorXd about = problem.shapes * squares;
  const double least = 1e-12 * problem.variances.maxCoeff();
  for (Eigen::Index k = 0; k < about.size(); ++k) {
    if (!(about(k) > 0)) about(k) = problem.variances(k);
    about(k) = std::max(about(k), std::max(least, std::numeric_limits<double>::min()));
  }
  return (2 * problem.relative_errors.array() * about.array()).inverse();
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

/// Standard errors of the squares when just these terms are fitted.
Eigen::VectorXd errors_of(const Problem& problem, const Terms& terms, const Fitted& about,
                          const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd map = estimator(problem, terms, weights_about(problem, about.squares));
  return (map * covariance * map.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
}

/// Terms leave one by one, the least certain first, until each that is left is seen.
Fitted fit_seen(const Problem& problem, Terms terms) {
  while (true) {
    Fitted fitted = fit_terms(problem, terms);
    if (fitted.terms.empty()) return fitted;
    const Eigen::MatrixXd covariance = allan_covariance(problem.curve, problem.rates, fitted.squares);
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
  const Eigen::MatrixXd map = estimator(problem, with, weights_about(problem, fitted.squares));
  const auto place = std::ranges::find(with, term) - with.begin();
  const double square = std::max(0.0, map.row(place).dot(problem.variances));
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
  const Problem problem = problem_of(curve, rates);
  constexpr std::array<Eigen::Index, kNoiseTerms> kByTau = {1, 0, 3, 2, 4};
  Terms terms(kByTau.begin(), kByTau.begin() + static_cast<std::ptrdiff_t>(std::min(kNoiseTerms, curve.size())));
  std::ranges::sort(terms);
  const Fitted fitted = fit_seen(problem, terms);
  const Eigen::MatrixXd covariance = allan_covariance(curve, rates, fitted.squares);
  AllanFit fit;
  for (std::size_t k = 0; k < kNoiseTerms; ++k) {
    fit.coefficients[k] = coefficient_of(problem, fitted, static_cast<NoiseTerm>(k), covariance);
  }
  const auto lowest = std::ranges::min_element(
      curve, {}, [&](const AllanPoint& point) { return deviation_of(fit, point.tau_s); });
  fit.lowest_tau_s = lowest->tau_s;
  return fit;
}

}  // namespace gyrotherm
