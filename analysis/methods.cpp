#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>

#include "analysis/baselines/linear.hpp"
#include "analysis/baselines/support_vectors.hpp"
#include "analysis/method.hpp"
#include "core/nearest.hpp"

namespace gyrotherm {
namespace {

constexpr std::array kMethods = {
    Method{.name = "svr",
           .title = "PSO-SVM",
           .citation = "Li et al., Sensors 15 (2015)",
           .inputs = "multi-point",
           .choose = choose_svr,
           .fit = fit_svr},
    Method{.name = "linear",
           .title = "Multiple linear regression",
           .citation = "Ding et al., Sensors 14 (2014) 18711",
           .inputs = "multi-point-t",
           .choose = choose_nothing,
           .fit = fit_linear},
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

double value_of(const HyperParameters& parameters, std::string_view name) {
  const auto found = std::ranges::find(parameters, name, &HyperParameter::name);
  assert(found != parameters.end());
  return found->value;
}

}  // namespace gyrotherm
