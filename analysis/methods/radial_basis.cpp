#include "analysis/methods/radial_basis.hpp"

#include <array>

#include "analysis/methods/centres.hpp"
#include "analysis/methods/held_out.hpp"
#include "analysis/methods/ridge_path.hpp"

namespace gyrotherm {
namespace {

constexpr std::array kCentres = {10, 20, 40, 80};
constexpr std::array kLambdas = {1e-2, 1e-4, 1e-6, 1e-8, 1e-10};

struct Units {
  SampleMatrix centres;
  Eigen::VectorXd widths;
};

Result<Units> place_units(const SampleMatrix& x, int count, std::uint64_t seed) {
  return k_means(x, count, seed).map([](KMeans&& found) {
    Eigen::VectorXd widths = neighbour_distances(found.centres);
    return Units{std::move(found.centres), std::move(widths)};
  });
}

}  // namespace

Result<Choice> choose_radial_basis(std::span<const Fold> folds, const MethodOptions& options,
                                   const ProgressSink& progress) {
  const Trial along_the_path = [&](const Fold& fold, std::size_t trial) -> Result<Eigen::MatrixXd> {
    const auto units = place_units(fold.train_x, kCentres[trial], options.seed);
    if (!units) return failure(units.error());
    const RidgePath path(gaussian_units(fold.train_x, units->centres, units->widths), fold.train_y);
    const Eigen::MatrixXd held_out = gaussian_units(fold.test_x, units->centres, units->widths);
    Eigen::MatrixXd predicted(fold.test_x.rows(), static_cast<Eigen::Index>(kLambdas.size()));
    for (Eigen::Index i = 0; i < predicted.cols(); ++i) {
      const Eigen::VectorXd weights = path.weights(kLambdas[i]);
      predicted.col(i) = (held_out * weights).array() + path.offset(weights);
    }
    return predicted;
  };
  const auto errors = held_out_errors(folds, kCentres.size(), along_the_path, options, progress);
  if (!errors) return failure(errors.error());
  const Least least = least_of(*errors);
  Choice choice;
  choice.parameters = {{"centres", static_cast<double>(kCentres[least.trial])}, {"lambda", kLambdas[least.candidate]}};
  return choice;
}

Result<Fit> fit_radial_basis(const FitInput& set, const HyperParameters& parameters, const MethodOptions& options) {
  if (const auto sound = check_set(set, 2); !sound) return failure(sound.error());
  auto units = place_units(set.x, static_cast<int>(value_of(parameters, "centres")), options.seed);
  if (!units) return failure(units.error());
  const double lambda = value_of(parameters, "lambda");
  const RidgePath path(gaussian_units(set.x, units->centres, units->widths), set.y);
  const Eigen::VectorXd weights = path.weights(lambda);
  return Fit{.function = ExpansionModel{.centres = std::move(units->centres),
                                        .lengths = Eigen::RowVectorXd::Ones(set.x.cols()),
                                        .widths = std::move(units->widths),
                                        .weights = weights,
                                        .b = path.offset(weights)},
             .effective_parameters = path.effective_parameters(lambda),
             .particulars = {}};
}

}  // namespace gyrotherm
