#include "analysis/fitting.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <utility>

namespace gyrotherm {

Result<Preparation> prepare(const InputPlan& plan, const Clusters& training) {
  ChosenInputs chosen = choose_inputs(plan, training);
  const auto inputs = evaluate(chosen.terms, training);
  if (!inputs) return failure(inputs.error());
  const auto scaling = fit_scaling(*inputs, chosen.terms);
  if (!scaling) return failure(scaling.error());
  const Figures target = figures_of(training.bias_deg_per_h);
  constexpr double kRounding = 1e-12;
  if (!(target.std > kRounding * target.max_abs)) {
    return failure(FaultKind::usage, "training", "the bias does not vary over the training clusters");
  }
  return Preparation{std::move(chosen.terms), std::move(chosen.selection), *scaling, target.mean, target.std};
}

Result<SampleMatrix> scaled_inputs(const Preparation& preparation, const Clusters& clusters) {
  return evaluate(preparation.terms, clusters).map([&](const SampleMatrix& inputs) {
    return apply(preparation.scaling, inputs);
  });
}

Eigen::VectorXd scaled_target(const Preparation& preparation, const Clusters& clusters) {
  return (clusters.bias_deg_per_h.array() - preparation.target_mean_deg_per_h) / preparation.target_std_deg_per_h;
}

Result<SvrModel> fit_svr(const SampleMatrix& x, const Eigen::VectorXd& y, const SvrParameters& parameters,
                         const SvrOptions& options) {
  const auto solution = solve_svr(x, y, parameters, options);
  if (!solution) return failure(solution.error());
  std::vector<Eigen::Index> support;
  for (Eigen::Index i = 0; i < solution->beta.size(); ++i) {
    if (solution->beta(i) != 0) support.push_back(i);
  }
  SampleMatrix vectors(static_cast<Eigen::Index>(support.size()), x.cols());
  for (Eigen::Index i = 0; i < vectors.rows(); ++i) vectors.row(i) = x.row(support[i]);
  return SvrModel{.support_vectors = std::move(vectors),
                  .beta = solution->beta(support),
                  .b = solution->b,
                  .parameters = parameters,
                  .relative_gap = solution->relative_gap,
                  .kkt_violation = solution->kkt_violation};
}

Result<LinearModel> fit_linear(const SampleMatrix& x, const Eigen::VectorXd& y, double target_std_deg_per_h) {
  Eigen::MatrixXd design(x.rows(), x.cols() + 1);
  design << x, Eigen::VectorXd::Ones(x.rows());
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr;
  qr.setThreshold(1e-9);
  qr.compute(design);
  if (x.rows() <= qr.rank()) {
    return failure(FaultKind::usage, "least squares",
                   fmt::format("{} clusters are too few for {} coefficients", x.rows(), qr.rank()));
  }
  const Eigen::VectorXd coefficients = qr.solve(y);
  const double squares = (y - design * coefficients).squaredNorm();
  const auto freedom = static_cast<double>(x.rows() - qr.rank());
  return LinearModel{.weights = coefficients.head(x.cols()),
                     .b = coefficients(x.cols()),
                     .residual_std_deg_per_h = target_std_deg_per_h * std::sqrt(squares / freedom)};
}

Model assemble(const Preparation& preparation, std::variant<SvrModel, LinearModel> function) {
  Model model;
  model.method = std::holds_alternative<SvrModel>(function) ? "svr" : "linear";
  model.function = std::move(function);
  model.terms = preparation.terms;
  model.scaling = preparation.scaling;
  model.target_mean_deg_per_h = preparation.target_mean_deg_per_h;
  model.target_std_deg_per_h = preparation.target_std_deg_per_h;
  model.selection = preparation.selection;
  return model;
}

}  // namespace gyrotherm
