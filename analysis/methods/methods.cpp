#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>

#include "analysis/methods/forward_prediction.hpp"
#include "analysis/methods/gaussian_process.hpp"
#include "analysis/methods/kohonen.hpp"
#include "analysis/methods/linear.hpp"
#include "analysis/methods/ls_svm.hpp"
#include "analysis/methods/method.hpp"
#include "analysis/methods/network.hpp"
#include "analysis/methods/polynomial.hpp"
#include "analysis/methods/radial_basis.hpp"
#include "analysis/methods/ridge.hpp"
#include "analysis/methods/stepwise.hpp"
#include "analysis/methods/support_vectors.hpp"
#include "core/text.hpp"

namespace gyrotherm {
namespace {

constexpr std::array kMethods = {
    Method{.name = "svr",
           .title = "PSO-SVM",
           .citation = "Li et al., Sensors 15 (2015)",
           .inputs = "multi-point",
           .choose = choose_svr,
           .fit = fit_svr},
    Method{.name = "svr-flp",
           .title = "PSO-SVM after a forward linear predictor",
           .citation = "Cheng et al., Measurement 55 (2014) 246",
           .inputs = "three-point",
           .choose = choose_svr,
           .fit = fit_svr,
           .filter = filter_bias},
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
           .choose = choose_nothing,
           .fit = fit_linear},
    Method{.name = "stepwise",
           .title = "Stepwise regression",
           .citation = "Zhang, Long, Opt. Tech. 32 (2006) 738",
           .inputs = "physics",
           .choose = choose_nothing,
           .fit = fit_stepwise},
    Method{.name = "ridge",
           .title = "Ridge regression on physics features",
           .citation = "Hoerl, Kennard, Technometrics 12 (1970) 55",
           .inputs = "physics",
           .choose = choose_ridge,
           .fit = fit_ridge},
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
           .choose = choose_radial_basis,
           .fit = fit_radial_basis},
    Method{.name = "kohonen-rbfnn",
           .title = "Radial basis network, Kohonen map and orthogonal least squares",
           .citation = "Ding et al., Sensors 14 (2014) 18711",
           .inputs = "temperature-gradient-rate",
           .choose = choose_kohonen,
           .fit = fit_kohonen},
    Method{.name = "ls-svm",
           .title = "Least-squares support vector machine",
           .citation = "Wei et al., Measurement 44 (2011) 1898",
           .inputs = "temperature-gradient-rate",
           .choose = choose_ls_svm,
           .fit = fit_ls_svm},
    Method{.name = "gp",
           .title = "Gaussian process regression",
           .citation = "Rasmussen, Williams, MIT Press (2006)",
           .inputs = "temperature-gradient-rate",
           .choose = choose_nothing,
           .fit = fit_gaussian_process},
};

}  // namespace

std::span<const Method> methods() { return kMethods; }

Result<const Method*> find_method(std::string_view name) {
  const auto found = std::ranges::find(kMethods, name, &Method::name);
  if (found != kMethods.end()) return found;
  std::vector<std::string> known;
  for (const Method& method : kMethods) known.emplace_back(method.name);
  const std::string meant = nearest(std::string(name), known);
  return failure(FaultKind::usage, "method",
                 fmt::format("\"{}\" is not one of {}{}", name, fmt::join(known, ", "),
                             meant.empty() ? "" : fmt::format("; did you mean {}?", meant)));
}

Result<void> check_folds(std::span<const Fold> folds) {
  if (folds.empty()) return failure(FaultKind::usage, "tuning", "no fold");
  for (std::size_t f = 0; f < folds.size(); ++f)
    if (auto sound = check_fold(folds[f], f); !sound) return sound;
  return {};
}

double value_of(const HyperParameters& parameters, std::string_view name) {
  const auto found = std::ranges::find(parameters, name, &HyperParameter::name);
  assert(found != parameters.end());
  return found->value;
}

}  // namespace gyrotherm
