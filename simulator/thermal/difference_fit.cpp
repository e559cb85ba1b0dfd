// SPDX-License-Identifier: Apache-2.0
#include "simulator/thermal/difference_fit.hpp"

#include <algorithm>
#include <cmath>

#include "simulator/thermal/mesh.hpp"
#include "simulator/thermal/steady_state.hpp"

namespace gyrotherm::thermal {
namespace {

/// A trial value of the parameter, and the resulting temperature difference minus the required one.
struct Trial {
  double value{};
  double error_k{};
  double warmest_c{};
};

class Search {
 public:
  Search(const GyroModel& model, FitParameter parameter, double wanted_k, const FitOptions& options,
         const ProgressSink& progress)
      : model_(model), parameter_(parameter), wanted_k_(wanted_k), options_(options), progress_(progress) {}

  Result<FittedDifference> run() {
    const auto range = fit_range(model_, parameter_);
    auto low = try_value(range.low);
    if (!low || fits(*low)) return make_result(low);
    auto high = try_value(range.high);
    if (!high || fits(*high)) return make_result(high);
    if (low->error_k * high->error_k > 0)
      return make_result(std::abs(low->error_k) < std::abs(high->error_k) ? low : high);
    return bisect(*low, *high);
  }

 private:
  [[nodiscard]] bool fits(const Trial& trial) const { return std::abs(trial.error_k) <= options_.tolerance_k; }

  Result<FittedDifference> bisect(Trial a, Trial b) {
    const bool logarithmic = a.value > 0 && b.value > 20 * a.value;
    const auto scale = [&](double value) { return logarithmic ? std::log(value) : value; };
    // End of the interval that was moved last: −1 a, 1 b.
    int side = 0;
    Result<Trial> last = a;
    while (steps_ < options_.most_steps) {
      const double at = (scale(a.value) * b.error_k - scale(b.value) * a.error_k) / (b.error_k - a.error_k);
      last = try_value(logarithmic ? std::exp(at) : at);
      if (!last || fits(*last)) return make_result(last);
      const int moved = last->error_k * a.error_k > 0 ? -1 : 1;
      (moved < 0 ? a : b) = *last;
      // Illinois method: the error at the other end is halved if the same end moves again.
      if (moved == side) (moved < 0 ? b : a).error_k /= 2;
      side = moved;
    }
    return make_result(last);
  }

  Result<Trial> try_value(double value) {
    if (!should_continue(progress_, kFitParameterNames[static_cast<std::size_t>(parameter_)],
                         static_cast<double>(steps_) / options_.most_steps))
      return failure(FaultKind::interrupted, "fit", "stopped on request");
    ++steps_;
    const auto model = replace_parameter(model_, parameter_, value);
    const auto mesh = make_mesh(model, options_.edge_mm);
    SteadyOptions steady;
    steady.ambient_c = options_.ambient_c;
    const auto state = steady_state(model, mesh, steady);
    if (!state) return failure(state.error());
    const auto& y = state->outputs_c;
    return Trial{value, gain_difference_k(y) - wanted_k_, *std::max_element(y.begin(), y.begin() + 8)};
  }

  [[nodiscard]] Result<FittedDifference> make_result(const Result<Trial>& trial) const {
    if (!trial) return failure(trial.error());
    return FittedDifference{parameter_,   trial->value,     trial->error_k + wanted_k_,
                            fits(*trial), trial->warmest_c, steps_};
  }

  const GyroModel& model_;
  FitParameter parameter_;
  double wanted_k_;
  const FitOptions& options_;
  const ProgressSink& progress_;
  int steps_ = 0;
};

/// Returns the thicknesses at which the block covers mirrors and cathode and leaves gaps of at least 5 mm to lid and
/// base, in which a preamplifier has space; only the present thickness if there are none.
FitRange thickness_range(const GyroModel& model) {
  const auto& g = model.geometry;
  const double inside = g.cabinet[2] - 2 * g.wall;
  const double low = std::max({g.mirror_height, g.cathode[2], 15.0});
  double high = std::min(60.0, inside - 10);
  if (model.mode == GyroMode::full && g.preamplifier_mount != PreamplifierMount::wall)
    high = std::min(high, inside - 2 * g.preamplifier[2]);
  return low <= high ? FitRange{low, high} : FitRange{g.block_thickness, g.block_thickness};
}

}  // namespace

GyroModel replace_parameter(const GyroModel& model, FitParameter parameter, double value) {
  auto changed = model;
  switch (parameter) {
    case FitParameter::emissivity:
      for (auto* gap : {&changed.air.lid, &changed.air.side, &changed.air.base}) gap->emissivity = value;
      break;
    case FitParameter::nusselt:
      for (auto* gap : {&changed.air.lid, &changed.air.side, &changed.air.base}) gap->nusselt = value;
      break;
    case FitParameter::thickness:
      changed.geometry.block_thickness = value;
      set_gap_widths(changed);
      break;
    case FitParameter::dither:
      changed.materials[static_cast<std::size_t>(GyroMaterial::dither)].conductivity_w_per_m_k = value;
      break;
    case FitParameter::film:
      (changed.mode == GyroMode::full ? changed.still_film_w_per_m2_k : changed.block_film_w_per_m2_k) = value;
      break;
  }
  return changed;
}

FitRange fit_range(const GyroModel& model, FitParameter parameter) {
  switch (parameter) {
    case FitParameter::emissivity: return {0, 1};
    case FitParameter::nusselt: return {0.5, 10};
    case FitParameter::thickness: return thickness_range(model);
    case FitParameter::dither: return {0.001, 10};
    case FitParameter::film: break;
  }
  return {0.5, 100};
}

Result<FittedDifference> fit_difference(const GyroModel& model, FitParameter parameter, double wanted_k,
                                        const FitOptions& options, const ProgressSink& progress) {
  return Search(model, parameter, wanted_k, options, progress).run();
}

Result<std::vector<FittedDifference>> fit_family(const GyroModel& model, double wanted_k, const FitOptions& options,
                                                 const ProgressSink& progress) {
  std::vector<FitParameter> parameters{FitParameter::film, FitParameter::thickness};
  if (model.mode == GyroMode::full) {
    parameters = {FitParameter::emissivity, FitParameter::nusselt, FitParameter::thickness, FitParameter::dither,
                  FitParameter::film};
  }
  std::vector<FittedDifference> family;
  for (const auto parameter : parameters) {
    auto fitted = fit_difference(model, parameter, wanted_k, options, progress);
    if (!fitted) return failure(fitted.error());
    family.push_back(*fitted);
  }
  return family;
}

}  // namespace gyrotherm::thermal
