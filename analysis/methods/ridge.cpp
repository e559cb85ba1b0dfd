#include "analysis/methods/ridge.hpp"

#include <cmath>

#include "analysis/methods/held_out.hpp"
#include "analysis/methods/ridge_path.hpp"

namespace gyrotherm {
namespace {

constexpr int kFirstDecade = -8, kLastDecade = 2;

}  // namespace

Result<Choice> choose_ridge(std::span<const Fold> folds, const MethodOptions& options, const ProgressSink& progress) {
  std::vector<double> lambdas;
  for (int decade = kLastDecade; decade >= kFirstDecade; --decade) lambdas.push_back(std::pow(10.0, decade));
  const Trial along_the_path = [&](const Fold& fold, std::size_t) -> Result<Eigen::MatrixXd> {
    const RidgePath path(fold.train_x, fold.train_y);
    Eigen::MatrixXd predicted(fold.test_x.rows(), static_cast<Eigen::Index>(lambdas.size()));
    for (Eigen::Index i = 0; i < predicted.cols(); ++i) {
      const Eigen::VectorXd weights = path.weights(lambdas[i]);
      predicted.col(i) = (fold.test_x * weights).array() + path.offset(weights);
    }
    return predicted;
  };
  const auto errors = held_out_errors(folds, 1, along_the_path, options, progress);
  if (!errors) return failure(errors.error());
  Choice choice;
  choice.parameters = {{"lambda", lambdas[least_of(*errors).candidate]}};
  return choice;
}

Result<Fit> fit_ridge(const FitInput& set, const HyperParameters& parameters, const MethodOptions&) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  const double lambda = value_of(parameters, "lambda");
  const RidgePath path(set.x, set.y);
  const Eigen::VectorXd weights = path.weights(lambda);
  return Fit{.function = LinearModel{.weights = weights, .b = path.offset(weights)},
             .effective_parameters = path.effective_parameters(lambda),
             .particulars = {}};
}

}  // namespace gyrotherm
