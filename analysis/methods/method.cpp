// SPDX-License-Identifier: Apache-2.0
#include "analysis/methods/method.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>

#include "analysis/methods/kernel_methods.hpp"
#include "analysis/methods/linear.hpp"
#include "analysis/methods/network.hpp"
#include "analysis/methods/radial_basis.hpp"
#include "analysis/methods/ridge_u.hpp"
#include "analysis/methods/svr.hpp"
#include "analysis/svm/gaussian_sum.hpp"
#include "core/text.hpp"

namespace gyrotherm::methods {
namespace {

// Each function evaluates its plane at `scaled` and its other parts at `bounded`.

Eigen::VectorXd value(const SvrModel& svr, const data::SampleMatrix&, const data::SampleMatrix& bounded) {
  const Eigen::VectorXd widths = Eigen::VectorXd::Constant(svr.beta.size(), svr.parameters.sigma);
  return svm::GaussianSum(svr.support_vectors, widths, svr.beta).at(bounded).array() + svr.b;
}

Eigen::VectorXd value(const LinearModel& linear, const data::SampleMatrix& scaled, const data::SampleMatrix&) {
  return (scaled * linear.weights).array() + linear.b;
}

Eigen::VectorXd value(const ExpansionModel& expansion, const data::SampleMatrix& scaled,
                      const data::SampleMatrix& bounded) {
  const auto in_lengths = [&](const data::SampleMatrix& rows) -> data::SampleMatrix {
    return rows.array().rowwise() / expansion.lengths.array();
  };
  const svm::GaussianSum sum(in_lengths(expansion.centres), expansion.widths, expansion.weights);
  const Eigen::VectorXd gaussians = sum.at(in_lengths(bounded)).array() + expansion.b;
  return expansion.slope.size() == 0 ? gaussians : Eigen::VectorXd(gaussians + scaled * expansion.slope);
}

Eigen::VectorXd value(const NetworkModel& network, const data::SampleMatrix&, const data::SampleMatrix& bounded) {
  const Eigen::MatrixXd sums = (bounded * network.weights.transpose()).rowwise() + network.offsets.transpose();
  return (sums.array().tanh().matrix() * network.out).array() + network.b;
}

int count_parameters(const SvrModel& svr) { return static_cast<int>(svr.support_vectors.size() + svr.beta.size()) + 2; }
int count_parameters(const LinearModel& linear) { return static_cast<int>((linear.weights.array() != 0).count()) + 1; }
int count_parameters(const ExpansionModel& expansion) {
  return static_cast<int>(expansion.centres.size() + expansion.lengths.size() + expansion.widths.size() +
                          expansion.weights.size() + expansion.slope.size()) +
         1;
}
int count_parameters(const NetworkModel& network) {
  return static_cast<int>(network.weights.size() + network.offsets.size() + network.out.size()) + 1;
}

/// Returns an empty choice, for methods without hyper-parameters.
Result<Choice> choose_nothing(std::span<const Fold>, const MethodOptions&, const ProgressSink&) { return Choice{}; }

constexpr std::array kMethods = {
    Method{.name = "svr",
           .title = "PSO-SVM",
           .citation = "Li et al., Sensors 15 (2015)",
           .inputs = "multi-point",
           .compared_on = {"three-point-t"},
           .choose = choose_svr,
           .fit = fit_svr,
           .tunes_svr = true},
    Method{.name = "svr-flp",
           .title = "PSO-SVM after a forward linear predictor",
           .citation = "Cheng et al., Measurement 55 (2014) 246",
           .inputs = "three-point",
           .choose = choose_svr,
           .fit = fit_svr,
           .filter = filter_bias,
           .tunes_svr = true},
    Method{.name = "svr-linear",
           .title = "PSO-SVM on the residual of a linear model",
           .citation = "after Li et al. (2015) and Fuller (1987)",
           .inputs = "temperatures",
           .compared_on = {"multi-point-t"},
           .choose = choose_svr_linear,
           .fit = fit_svr_linear,
           .tunes_svr = true,
           .uses_uncertainty = true},
    Method{.name = "lsf",
           .title = "Least-squares polynomial",
           .citation = "Guo et al., Chin. Opt. Lett. 4 (2006) 576",
           .inputs = "polynomial",
           .choose = choose_polynomial,
           .fit = fit_polynomial},
    Method{.name = "linear",
           .title = "Multiple linear regression",
           .citation = "Ding et al., Sensors 14 (2014) 18711",
           .inputs = "temperature-gradient-rate",
           .compared_on = {"three-point", "three-point-t", "multi-point", "multi-point-t", "seven-point"},
           .choose = choose_nothing,
           .fit = fit_linear},
    Method{.name = "stepwise",
           .title = "Stepwise regression",
           .citation = "Zhang, Long, Opt. Tech. 32 (2006) 738",
           .inputs = "physics",
           .compared_on = {"multi-point-t"},
           .choose = choose_nothing,
           .fit = fit_stepwise},
    Method{.name = "ridge",
           .title = "Ridge regression on physics features",
           .citation = "Hoerl, Kennard, Technometrics 12 (1970) 55",
           .inputs = "physics",
           .compared_on = {"multi-point-t"},
           .choose = choose_ridge,
           .fit = fit_ridge},
    Method{.name = "ridge-u",
           .title = "Ridge regression, penalty of the thermometers' uncertainty",
           .citation = "Fuller, Measurement Error Models (1987)",
           .inputs = "temperatures",
           .compared_on = {"thermal-history"},
           .choose = choose_nothing,
           .fit = fit_ridge_u,
           .uses_uncertainty = true},
    Method{.name = "state-space",
           .title = "State space of a few real poles",
           .citation = "Golub, Pereyra, SIAM J. Numer. Anal. 10 (1973) 413",
           .inputs = "lag-bank",
           .compared_on = {},
           .choose = choose_state_space,
           .fit = fit_state_space,
           .uses_uncertainty = true},
    Method{.name = "bpnn",
           .title = "Back-propagation network",
           .citation = "Yang et al., Proc. SPIE 7544 (2010)",
           .inputs = "temperature-gradient-rate",
           .choose = choose_network,
           .fit = fit_network},
    Method{.name = "rbfnn",
           .title = "Radial basis network, k-means centres",
           .citation = "Jin et al., Opt. Precis. Eng. 16 (2008) 235",
           .inputs = "temperature-gradient-rate",
           .compared_on = {"multi-point-t"},
           .choose = choose_radial_basis,
           .fit = fit_radial_basis},
    Method{.name = "kohonen-rbfnn",
           .title = "Radial basis network, Kohonen map and orthogonal least squares",
           .citation = "Ding et al., Sensors 14 (2014) 18711",
           .inputs = "temperature-gradient-rate",
           .compared_on = {"multi-point-t"},
           .choose = choose_kohonen,
           .fit = fit_kohonen},
    Method{.name = "ls-svm",
           .title = "Least-squares support vector machine",
           .citation = "Wei et al., Measurement 44 (2011) 1898",
           .inputs = "temperature-gradient-rate",
           .compared_on = {"multi-point-t"},
           .choose = choose_ls_svm,
           .fit = fit_ls_svm},
    Method{.name = "gp",
           .title = "Gaussian process regression",
           .citation = "Rasmussen, Williams, MIT Press (2006)",
           .inputs = "temperature-gradient-rate",
           .compared_on = {"multi-point-t", "temperatures"},
           .choose = choose_nothing,
           .fit = fit_gaussian_process,
           .uses_uncertainty = true},
};

}  // namespace

Eigen::VectorXd evaluate_function(const Function& function, const data::SampleMatrix& scaled) {
  return evaluate_function(function, scaled, scaled);
}

Eigen::VectorXd evaluate_function(const Function& function, const data::SampleMatrix& scaled,
                                  const data::SampleMatrix& bounded) {
  return std::visit([&](const auto& form) { return value(form, scaled, bounded); }, function);
}

int count_stored_numbers(const Function& function) {
  return std::visit([](const auto& form) { return count_parameters(form); }, function);
}

PredictiveVariance plane_variance(Eigen::MatrixXd open, double noise) {
  constexpr double kUnboundedLength = 1e12;
  const Eigen::Index inputs = open.cols() - 1;
  return {.centres = data::SampleMatrix::Zero(1, inputs),
          .lengths = Eigen::RowVectorXd::Constant(inputs, kUnboundedLength),
          .signal = 1,
          .noise = noise,
          .posterior = std::move(open),
          .root = Eigen::MatrixXd::Ones(1, 1)};
}

Eigen::MatrixXd compute_features(const PredictiveVariance& variance, const data::SampleMatrix& scaled) {
  const Covariance covariance{.lengths = variance.lengths, .signal = variance.signal, .noise = variance.noise};
  const Eigen::MatrixXd kernel = covariance_matrix(covariance, scaled, variance.centres);
  Eigen::MatrixXd features(scaled.rows(), scaled.cols() + kernel.cols());
  features << scaled, variance.root.triangularView<Eigen::Lower>().solve(kernel.transpose()).transpose();
  return features;
}

Eigen::VectorXd evaluate_variance(const PredictiveVariance& variance, const data::SampleMatrix& scaled) {
  const Eigen::MatrixXd features = compute_features(variance, scaled);
  const Eigen::VectorXd known = (features * variance.posterior).cwiseProduct(features).rowwise().sum();
  const Eigen::VectorXd explained = features.rightCols(variance.centres.rows()).rowwise().squaredNorm();
  return (known.array() + (variance.signal * variance.signal - explained.array()).max(0)).max(0);
}

std::span<const Method> methods() { return kMethods; }

Result<const Method*> find_method(std::string_view name) {
  const auto found = std::ranges::find(kMethods, name, &Method::name);
  if (found != kMethods.end()) return found;
  std::vector<std::string> known;
  for (const Method& method : kMethods) known.emplace_back(method.name);
  const std::string meant = find_nearest(std::string(name), known);
  return failure(FaultKind::usage, "method",
                 fmt::format("\"{}\" is not one of {}{}", name, fmt::join(known, ", "),
                             meant.empty() ? "" : fmt::format("; did you mean {}?", meant)));
}

double parameter_value(const HyperParameters& parameters, std::string_view name) {
  const auto found = std::ranges::find(parameters, name, &HyperParameter::name);
  assert(found != parameters.end());
  return found->value;
}

}  // namespace gyrotherm::methods
