// SPDX-License-Identifier: Apache-2.0
/// The uncertainty budget of a mean of compensated bias, after the Guide to the Expression of Uncertainty in
/// Measurement (GUM, JCGM 100:2008): one row a source, what they come to together, and by how much that is expanded.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/form.hpp"

namespace gyrotherm::model {

/// What makes a mean of compensated bias uncertain.
enum class Source {
  angle_random_walk,
  flicker,
  rate_random_walk,
  counting,           ///< of pulses: a mean begins and ends somewhere between two of them
  thermometer_noise,  ///< what the compensation itself adds, √Σ(c_i n_i)²
  model_form,         ///< held-out residual that neither noise nor hysteresis explains
  coefficients,       ///< what a unit's own hours and its type leave open of them; of a model with a type prior
  hysteresis,
  turn_on,
  thermometer_drift,        ///< since the thermometer was calibrated
  input_drift,              ///< drift of any other input
  thermometer_calibration,  ///< of its certificate
  latitude,
  azimuth,
  tilt,               ///< no fixture
  fixture_elevation,  ///< fixture
  fixture_roll,
  axis_direction,  ///< in its fixture
  scale_factor
};
[[nodiscard]] const char* name(Source source);
/// Returns true if its error is the drift of a thermometer or another input, which grows with time.
[[nodiscard]] inline bool is_drift(Source source) {
  return source == Source::thermometer_drift || source == Source::input_drift;
}

/// Whether the error of a source is another one in each mean, in each run, or the same in training and in use: then the
/// model has learnt it, and no run of the same rig shows it.
enum class Differs { within_a_run, between_runs, never };
[[nodiscard]] const char* name(Differs differs);
[[nodiscard]] Differs differs(Source source);

/// How a standard uncertainty was evaluated: from a series of observations, or from what else is known (GUM 0.7).
enum class Evaluation { a, b };
[[nodiscard]] const char* name(Evaluation evaluation);

enum class ErrorDistribution { normal, rectangular, triangular };
[[nodiscard]] const char* name(ErrorDistribution distribution);

struct BudgetRow {
  Source source{};
  std::string of{};    ///< thermometer or other input
  std::string unit{};  ///< for input_drift alone
  Evaluation evaluation{};
  ErrorDistribution distribution{};
  double standard_uncertainty{};  ///< k = 1, in the unit of its source
  double sensitivity = 1;         ///< °/h per unit: how far the bias goes with the source
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  bool assumed{};  ///< the record does not say it: a default of this program
  /// The residual of this row has also chosen the model's parameters.
  bool chosen_on_these_folds{};
  /// The training has one power-on: the fold that holds it out has none left to learn from.
  bool only_start_held_out{};
};

/// Returns the unit of the standard uncertainty: "°/h", "K", "°", "ppm", or that of its input; "1" without one.
[[nodiscard]] std::string unit_of(const BudgetRow& row);

/// Returns the remarks on a row that hold, in this order: "assumed", "chosen on these folds", "its only power-on held
/// out".
[[nodiscard]] std::vector<std::string> remarks(const BudgetRow& row);

/// |c|·u, °/h.
[[nodiscard]] double contribution_deg_per_h(const BudgetRow& row);

/// Of a mean of compensated bias over `averaging_s`.
struct Budget {
  double averaging_s{};
  std::vector<BudgetRow> rows;
};

/// What the rows come to.
struct CombinedUncertainty {
  double standard_deg_per_h{};  ///< u_c
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  double coverage_factor{};     ///< k
  double expanded_deg_per_h{};  ///< U = k·u_c
};

inline constexpr double kCoverage = 0.95;  ///< share of errors within U

/// Of a standard uncertainty that is itself known to a standard error: ½(u/Δu)² (GUM G.3), at least 1; infinite where
/// the error is 0.
[[nodiscard]] double degrees_of_freedom_of(double uncertainty, double error);

/// Independent sources: u_c² = Σ(c_i u_i)² (GUM 5.1.2); the effective degrees of freedom are u_c⁴/Σ((c_i u_i)⁴/ν_i)
/// (Welch and Satterthwaite, GUM G.2b), and k is Student's t for them, cut to a whole number (G.4.1). All is 0 of no
/// row that contributes, with infinite degrees of freedom.
[[nodiscard]] CombinedUncertainty combined(const std::vector<BudgetRow>& rows, double share = kCoverage);

/// The rows whose errors differ from run to run or within one: what a run that a model has not seen can show.
[[nodiscard]] std::vector<BudgetRow> that_differ(const std::vector<BudgetRow>& rows);

/// The budget of means over another time: white noise goes with 1/√τ, the counting of pulses with 1/τ, rate random walk
/// with √τ, all else stays.
[[nodiscard]] Budget at_averaging(Budget budget, double averaging_s);

/// ∂b/∂T of one thermometer, °/h per K, over the clusters of a record.
struct Sensitivity {
  std::string thermometer;
  double mean{};      ///< signed
  double rms{};       ///< root mean square: what a budget takes
  double greatest{};  ///< magnitude
};

/// What is known of how uncertain a model's compensated bias is, as it was trained.
struct Uncertainty {
  Budget budget;                           ///< of a mean over 1 h
  std::vector<Sensitivity> sensitivities;  ///< of the thermometers that the model asks for, over its training clusters
  double added_noise_deg_per_h{};          ///< that the compensation adds to one cluster's mean, √Σ(c_i n_i)²
  /// Mean of the model's own variance over its training clusters, (°/h)²: the part of it that the held-out residual,
  /// and so the row of the model's form, contains. NaN where the model does not know its variance, or it is a row by
  /// itself.
  double variance_in_training = std::numeric_limits<double>::quiet_NaN();
};

/// What the budget comes to for a mean over another time.
[[nodiscard]] CombinedUncertainty of_mean_over(const Uncertainty& uncertainty, double averaging_s);

/// Returns what is added to the variance of a mean whose worst input lies `excess` of its trained range outside, in
/// units of the variance of the model's form: 3((1 + 2·excess)² − 1). It is how the square of an error that is a
/// straight line over the range, with the form's mean square in it, grows beyond the end.
[[nodiscard]] double widening(double excess);

/// Returns the variance of the model's form in a budget, (°/h)²: the row that widening() multiplies.
[[nodiscard]] double form_variance(const std::vector<BudgetRow>& rows);

/// Returns U of a mean over that time whose worst input lies `excess` of its trained range outside, °/h.
[[nodiscard]] double expanded_outside(const Uncertainty& uncertainty, double averaging_s, double excess);

void describe(auto& form, Like<BudgetRow> auto& row) {
  form("source", one_of(row.source, {Source::angle_random_walk, Source::flicker, Source::rate_random_walk,
                                     Source::counting, Source::thermometer_noise, Source::model_form,
                                     Source::coefficients, Source::hysteresis, Source::turn_on,
                                     Source::thermometer_drift, Source::input_drift, Source::thermometer_calibration,
                                     Source::latitude, Source::azimuth, Source::tilt, Source::fixture_elevation,
                                     Source::fixture_roll, Source::axis_direction, Source::scale_factor}));
  form.if_there("of", !row.of.empty(), row.of);
  form("type", one_of(row.evaluation, {Evaluation::a, Evaluation::b}));
  form("distribution", one_of(row.distribution, {ErrorDistribution::normal, ErrorDistribution::rectangular,
                                                 ErrorDistribution::triangular}));
  form("standard_uncertainty", not_negative(row.standard_uncertainty));
  auto unit = unit_of(row);
  form("unit", unit);
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(row)>>)
    if (row.source == Source::input_drift) row.unit = unit;
  form("sensitivity_deg_per_h_per_unit", row.sensitivity);
  form.derived("contribution_deg_per_h", contribution_deg_per_h(row));
  form.if_there("degrees_of_freedom", row.degrees_of_freedom < std::numeric_limits<double>::infinity(),
                positive(row.degrees_of_freedom));
  form.derived("differs", name(differs(row.source)));
  form("assumed", row.assumed);
  form.if_there("chosen_on_these_folds", row.chosen_on_these_folds, row.chosen_on_these_folds);
  form.if_there("only_start_held_out", row.only_start_held_out, row.only_start_held_out);
}

void describe(auto& form, Like<CombinedUncertainty> auto& uncertainty) {
  form("u_deg_per_h", uncertainty.standard_deg_per_h);
  form.if_there("degrees_of_freedom", uncertainty.degrees_of_freedom < std::numeric_limits<double>::infinity(),
                uncertainty.degrees_of_freedom);
  form("k", uncertainty.coverage_factor);
  form("U_deg_per_h", uncertainty.expanded_deg_per_h);
}

void describe(auto& form, Like<Sensitivity> auto& sensitivity) {
  form("thermometer", sensitivity.thermometer);
  form("mean_deg_per_h_per_k", sensitivity.mean);
  form("rms_deg_per_h_per_k", not_negative(sensitivity.rms));
  form("greatest_deg_per_h_per_k", not_negative(sensitivity.greatest));
}

/// Whether both come to the same, but for rounding.
[[nodiscard]] bool agree(const CombinedUncertainty& a, const CombinedUncertainty& b);

/// Degrees of freedom that do not stand in the file are infinite. What it comes to may be left out of a file; where it
/// stands it is what the rows come to.
void describe(auto& form, Like<Uncertainty> auto& uncertainty) {
  form("averaging_s", positive(uncertainty.budget.averaging_s));
  form.derived("coverage", kCoverage);
  std::optional<CombinedUncertainty> said;
  if constexpr (std::is_const_v<std::remove_reference_t<decltype(uncertainty)>>)
    said = combined(uncertainty.budget.rows);
  form.if_there("combined", said.has_value(), said);
  form("budget", uncertainty.budget.rows);
  form.expect("combined", !said || agree(*said, combined(uncertainty.budget.rows)),
              "does not say the same as the rows of the budget");
  form("sensitivities", uncertainty.sensitivities);
  form("added_noise_deg_per_h", not_negative(uncertainty.added_noise_deg_per_h));
  form.if_there("variance_in_training", std::isfinite(uncertainty.variance_in_training),
                not_negative(uncertainty.variance_in_training));
}

}  // namespace gyrotherm::model
