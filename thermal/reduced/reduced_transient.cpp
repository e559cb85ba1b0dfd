#include "thermal/reduced/reduced_transient.hpp"

#include <Eigen/Cholesky>
#include <cassert>
#include <cmath>
#include <variant>

#include "thermal/reduced/step_table.hpp"
#include "thermal/reduced/thermal_modes.hpp"

namespace gyrotherm {

double gap_air_c(const Eigen::Ref<const Eigen::VectorXd>& outputs_c) {
  return (outputs_c[static_cast<Eigen::Index>(ThermalOutput::block)] +
          outputs_c[static_cast<Eigen::Index>(ThermalOutput::shell)]) /
         2;
}

Eigen::VectorXd rest_of(const ReducedModel& model, GyroFilm film, double air_c) {
  constexpr int kMostRounds = 100;
  constexpr double kSettled_k = 1e-10;
  double gap_c = air_c;
  Eigen::VectorXd states;
  for (int round = 0; round < kMostRounds; ++round) {
    states = states_at(model, coefficients_at(model, gap_c, film), 0) * switched_on(model, air_c);
    const double next_c = gap_air_c(model.outputs * states);
    if (std::abs(next_c - gap_c) <= kSettled_k) break;
    gap_c = next_c;
  }
  return states;
}

struct ReducedTransient::Parts {
  /// Constant coefficients: the states are amplitudes of modes.
  class ModalStep final {
   public:
    ModalStep(const ReducedModel& model, const ThermalCoefficients& c, Eigen::VectorXd& states,
              Eigen::MatrixXd& outputs) {
      const auto modes = modes_of(model, c);
      const auto weights = modal_weights(modes.rates_per_s, 1);
      const Eigen::MatrixXd inputs = modes.shapes.transpose() * inputs_at(model, c);
      decay_ = weights.decay;
      before_ = weights.before * inputs.col(0).array();
      after_ = weights.after * inputs.col(0).array();
      powers_ = (weights.before + weights.after) * (inputs * switched_on(model, 0)).array();
      states = (modes.shapes.transpose() * states).eval();
      outputs = (outputs * modes.shapes).eval();
    }

    void step(Eigen::VectorXd& states, double from_c, double to_c) const {
      states.array() = decay_ * states.array() + before_ * from_c + after_ * to_c + powers_;
    }

   private:
    Eigen::ArrayXd decay_, before_, after_, powers_;
  };

  Parts(const ReducedModel& model, const ReducedTransientOptions& chosen)
      : options(chosen),
        air_c(chosen.start.value),
        states(rest_of(model, chosen.film, air_c)),
        outputs(model.outputs),
        law(law_of(model, chosen, states, outputs)) {
    publish();
  }

  static std::variant<ModalStep, StepTable> law_of(const ReducedModel& model, const ReducedTransientOptions& chosen,
                                                   Eigen::VectorXd& start, Eigen::MatrixXd& rows) {
    if (!chosen.linear) return StepTable(model, chosen.film);
    return ModalStep(model, coefficients_at(model, gap_air_c(rows * start), chosen.film), start, rows);
  }

  void publish() { outputs_c.noalias() = outputs * states; }

  ReducedTransientOptions options;
  double air_c;
  long seconds = 0;
  Eigen::VectorXd states;
  Eigen::MatrixXd outputs;  ///< of the states as the law keeps them
  std::variant<ModalStep, StepTable> law;
  Eigen::Vector<double, kThermalOutputs> outputs_c;
};

ReducedTransient::ReducedTransient(const ReducedModel& model, const ReducedTransientOptions& options)
    : parts_(std::make_unique<Parts>(model, options)) {
  assert(options.seconds_per_update >= 1);
}
ReducedTransient::~ReducedTransient() = default;
ReducedTransient::ReducedTransient(ReducedTransient&&) noexcept = default;
ReducedTransient& ReducedTransient::operator=(ReducedTransient&&) noexcept = default;

void ReducedTransient::step(Celsius air) {
  auto& p = *parts_;
  if (auto* table = std::get_if<StepTable>(&p.law)) {
    if (p.seconds % p.options.seconds_per_update == 0) table->update(gap_air_c(p.outputs_c));
    table->step(p.states, p.air_c, air.value);
  } else {
    std::get<Parts::ModalStep>(p.law).step(p.states, p.air_c, air.value);
  }
  p.air_c = air.value;
  ++p.seconds;
  p.publish();
}

std::span<const double, kThermalOutputs> ReducedTransient::outputs_c() const {
  return std::span<const double, kThermalOutputs>(parts_->outputs_c.data(), kThermalOutputs);
}

}  // namespace gyrotherm
