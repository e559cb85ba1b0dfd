#include "simulator/reduced_gyro.hpp"

namespace gyrotherm {
namespace {

static_assert(static_cast<std::size_t>(ThermalOutput::h) + 1 == kBlockPlaces);
static_assert(static_cast<std::size_t>(ThermalOutput::shell) + 1 == kThermalPlaces);

/// The powers come after the ambient.
double& power_w(ReducedModel& model, ThermalInput input) { return model.powers_w[static_cast<std::size_t>(input) - 1]; }

void share(double& left_w, double& right_w, double left_over_right) {
  const double factor = left_w * left_over_right;
  const double sum = left_w + right_w;
  if (factor + right_w == 0) return;
  left_w = sum * factor / (factor + right_w);
  right_w = sum - left_w;
}

void add_lead(ReducedModel& model, ThermalOutput arm, double w_per_k) {
  const auto row = [&](ThermalOutput output) { return model.outputs.row(static_cast<Eigen::Index>(output)); };
  const Eigen::VectorXd drop = (row(arm) - row(ThermalOutput::shell)).transpose();
  model.conduction += w_per_k * drop * drop.transpose();
}

}  // namespace

ReducedModel with_unequal_arms(ReducedModel model, const UnequalArms& arms) {
  share(power_w(model, ThermalInput::gain_left), power_w(model, ThermalInput::gain_right), arms.gain_left_over_right);
  share(power_w(model, ThermalInput::ballast_left), power_w(model, ThermalInput::ballast_right),
        arms.ballast_left_over_right);
  add_lead(model, ThermalOutput::gain_left, arms.left_lead_w_per_k);
  add_lead(model, ThermalOutput::gain_right, arms.right_lead_w_per_k);
  return model;
}

ReducedGyro::ReducedGyro(const ReducedGyroParameters& parameters)
    : reduced_(with_unequal_arms(parameters.model, parameters.arms),
               {.start = {parameters.start_c}, .film = parameters.film}),
      bias_(parameters.bias, reduced_.outputs_c()) {}

void ReducedGyro::step(Celsius air) {
  reduced_.step(air);
  bias_.step(reduced_.outputs_c());
}

}  // namespace gyrotherm
