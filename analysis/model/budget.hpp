// SPDX-License-Identifier: Apache-2.0
/// The uncertainty budget of a mean of compensated bias, after the Guide to the Expression of Uncertainty in
/// Measurement (GUM, JCGM 100:2008): one row per source, the combined uncertainty and the expanded uncertainty.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/form.hpp"

namespace gyrotherm::model {

/// Source of uncertainty of a mean of compensated bias.
enum class Source {
  angle_random_walk,
  flicker,
  rate_random_walk,
  /// Quantisation: the first and the last pulse of a mean do not coincide with its start and end.
  counting,
  /// Noise that the compensation adds, √Σ(c_i n_i)²: c_i is the sensitivity to thermometer i and n_i its noise.
  thermometer_noise,
  /// Held-out residual that neither noise nor hysteresis explains.
  model_form,
  /// Uncertainty of the coefficients of a model with a type prior, given the type and the unit's own record.
  coefficients,
  hysteresis,
  turn_on,
  thermometer_drift,  ///< of a thermometer since its calibration
  input_drift,        ///< any other input
  thermometer_calibration,
  latitude,
  azimuth,
  tilt,               ///< no fixture
  fixture_elevation,  ///< fixture
  fixture_roll,
  axis_direction,  ///< of the axis in its fixture
  scale_factor,
  extrapolation  ///< use outside the trained range
};
[[nodiscard]] const char* name(Source source);
/// Returns true if the error of this source is the drift of a thermometer or another input, which grows with time.
[[nodiscard]] inline bool is_drift(Source source) {
  return source == Source::thermometer_drift || source == Source::input_drift;
}

/// Time scale on which the error of a source varies. An error that never varies is equal in training and in use: the
/// model has learnt it, and no run of the same rig can reveal it.
enum class Variability { within_a_run, between_runs, never };
[[nodiscard]] const char* name(Variability variability);
[[nodiscard]] Variability variability(Source source);

/// Evaluation of a standard uncertainty: type A from a series of observations, type B from other knowledge (GUM 0.7).
enum class Evaluation { a, b };
[[nodiscard]] const char* name(Evaluation evaluation);

enum class ErrorDistribution { normal, rectangular, triangular };
[[nodiscard]] const char* name(ErrorDistribution distribution);

struct BudgetRow {
  Source source{};
  /// Name of the thermometer or other input.
  std::string of{};
  /// Unit of an input_drift row; empty for other rows.
  std::string unit{};
  Evaluation evaluation{};
  ErrorDistribution distribution{};
  /// Standard uncertainty in row_unit(row), k = 1.
  double standard_uncertainty{};
  /// Change of the bias per unit of the source, °/h.
  double sensitivity = 1;
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  /// True if the record does not state the value, so this program assumes one.
  bool assumed{};
  /// True if the residual of this row was also used to choose the model's parameters.
  bool chosen_on_these_folds{};
  /// True if the training data have a single power-on, so no fold can predict one power-on from another.
  bool only_start_held_out{};
  /// True if the noise was estimated from the held-out residual, because no record has a hold.
  bool without_holds{};
};

/// Returns the unit of the standard uncertainty: "°/h", "K", "°", "ppm", or the unit of the input; "1" if it has none.
[[nodiscard]] std::string row_unit(const BudgetRow& row);

/// Returns the remarks that apply to a row, in this order: "assumed", "chosen on these folds", "only power-on held
/// out", "from the residual, no holds".
[[nodiscard]] std::vector<std::string> remarks(const BudgetRow& row);

/// Returns |c|·u, °/h.
[[nodiscard]] double contribution_deg_per_h(const BudgetRow& row);

/// Uncertainty budget of a mean of compensated bias over `averaging_s`.
struct Budget {
  double averaging_s{};
  std::vector<BudgetRow> rows;
};

/// Combined and expanded uncertainty of the rows of a budget.
struct CombinedUncertainty {
  double standard_deg_per_h{};  ///< u_c
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  double coverage_factor{};     ///< k
  double expanded_deg_per_h{};  ///< U = k·u_c
};

/// Coverage probability of U.
inline constexpr double kCoverage = 0.95;

/// Returns the degrees of freedom of a standard uncertainty u with standard error Δu: ½(u/Δu)² (GUM G.3), at least 1;
/// infinite if the error is 0.
[[nodiscard]] double degrees_of_freedom_for(double uncertainty, double error);

/// Truncates degrees of freedom to a whole number, at least 1 (GUM G.4.1). A number that is below a whole number only
/// by a rounding error counts as that number. A number that is not finite is unchanged.
[[nodiscard]] double whole_degrees(double degrees_of_freedom);

/// Combines rows of independent sources: u_c² = Σ(c_i u_i)² (GUM 5.1.2). The effective degrees of freedom are
/// u_c⁴/Σ((c_i u_i)⁴/ν_i) (Welch and Satterthwaite, GUM G.2b), and k is Student's t for whole_degrees() of them. If no
/// row contributes, the uncertainties are 0 and the degrees of freedom infinite.
[[nodiscard]] CombinedUncertainty combined(const std::vector<BudgetRow>& rows, double share = kCoverage);

/// Returns the rows whose errors differ between runs or within a run. Only these errors are observable in an unseen
/// run.
[[nodiscard]] std::vector<BudgetRow> differing_rows(const std::vector<BudgetRow>& rows);

/// Converts a budget to means over another time: white noise changes as 1/√τ, quantisation as 1/τ, rate random walk as
/// √τ. All other sources are unchanged.
[[nodiscard]] Budget convert_averaging(Budget budget, double averaging_s);

/// ∂b/∂T of one thermometer, °/h per K, over the clusters of a record.
struct Sensitivity {
  std::string thermometer;
  double mean{};  ///< signed
  /// Root mean square, used in the budget.
  double rms{};
  double greatest{};  ///< magnitude
};

/// Uncertainty of a model's compensated bias, evaluated when the model was trained.
struct Uncertainty {
  /// Budget of a mean over 1 h.
  Budget budget;
  /// Sensitivities to the thermometers that the model uses, over its training clusters.
  std::vector<Sensitivity> sensitivities;
  /// Noise that the compensation adds to the mean of one cluster, √Σ(c_i n_i)², °/h.
  double added_noise_deg_per_h{};
  /// Mean of the model's predictive variance over its training clusters, (°/h)². The held-out residual includes this
  /// variance, and so does the model form row. NaN if the model has no predictive variance, or if the budget has a
  /// separate row for it.
  double variance_in_training = std::numeric_limits<double>::quiet_NaN();
};

/// Returns the combined uncertainty of a mean over `averaging_s`.
[[nodiscard]] CombinedUncertainty mean_uncertainty(const Uncertainty& uncertainty, double averaging_s);

/// Returns the variance to be added to a mean whose worst input is outside its trained range by `excess` times that
/// range, in units of the model form variance: 3((1 + 2·excess)² − 1). The formula assumes an error that is linear in
/// the input, inside and outside the range, and that has the mean square of the model form inside.
[[nodiscard]] double extrapolation_factor(double excess);

/// Returns the variance of the model form in a budget, (°/h)². extrapolation_factor() is a multiple of it.
[[nodiscard]] double form_variance(const std::vector<BudgetRow>& rows);

/// Returns U of a mean over `averaging_s`, °/h, when the worst input is outside its trained range by `excess` times
/// that range.
[[nodiscard]] double expanded_outside(const Uncertainty& uncertainty, double averaging_s, double excess);

void describe(auto& form, Like<BudgetRow> auto& row) {
  form("source",
       one_of(row.source, {Source::angle_random_walk, Source::flicker,           Source::rate_random_walk,
                           Source::counting,          Source::thermometer_noise, Source::model_form,
                           Source::coefficients,      Source::hysteresis,        Source::turn_on,
                           Source::thermometer_drift, Source::input_drift,       Source::thermometer_calibration,
                           Source::latitude,          Source::azimuth,           Source::tilt,
                           Source::fixture_elevation, Source::fixture_roll,      Source::axis_direction,
                           Source::scale_factor,      Source::extrapolation}));
  form.if_present("of", !row.of.empty(), row.of);
  form("type", one_of(row.evaluation, {Evaluation::a, Evaluation::b}));
  form("distribution", one_of(row.distribution, {ErrorDistribution::normal, ErrorDistribution::rectangular,
                                                 ErrorDistribution::triangular}));
  form("standard_uncertainty", not_negative(row.standard_uncertainty));
  auto unit = row_unit(row);
  form("unit", unit);
  if constexpr (!std::is_const_v<std::remove_reference_t<decltype(row)>>)
    if (row.source == Source::input_drift) row.unit = unit;
  form("sensitivity_deg_per_h_per_unit", row.sensitivity);
  form.derived("contribution_deg_per_h", contribution_deg_per_h(row));
  form.if_present("degrees_of_freedom", row.degrees_of_freedom < std::numeric_limits<double>::infinity(),
                  positive(row.degrees_of_freedom));
  form.derived("differs", name(variability(row.source)));
  form("assumed", row.assumed);
  form.if_present("chosen_on_these_folds", row.chosen_on_these_folds, row.chosen_on_these_folds);
  form.if_present("only_start_held_out", row.only_start_held_out, row.only_start_held_out);
  form.if_present("without_holds", row.without_holds, row.without_holds);
}

void describe(auto& form, Like<CombinedUncertainty> auto& uncertainty) {
  form("u_deg_per_h", uncertainty.standard_deg_per_h);
  form.if_present("degrees_of_freedom", uncertainty.degrees_of_freedom < std::numeric_limits<double>::infinity(),
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

/// Returns true if both are equal except for rounding.
[[nodiscard]] bool are_nearly_equal(const CombinedUncertainty& a, const CombinedUncertainty& b);

/// Describes the file format. Missing degrees of freedom are infinite. The combined uncertainty is optional; if
/// present, it must equal that of the rows.
void describe(auto& form, Like<Uncertainty> auto& uncertainty) {
  form("averaging_s", positive(uncertainty.budget.averaging_s));
  form.derived("coverage", kCoverage);
  std::optional<CombinedUncertainty> stated;
  if constexpr (std::is_const_v<std::remove_reference_t<decltype(uncertainty)>>)
    stated = combined(uncertainty.budget.rows);
  form.if_present("combined", stated.has_value(), stated);
  form("budget", uncertainty.budget.rows);
  form.expect("combined", !stated || are_nearly_equal(*stated, combined(uncertainty.budget.rows)),
              "does not match the rows of the budget");
  form("sensitivities", uncertainty.sensitivities);
  form("added_noise_deg_per_h", not_negative(uncertainty.added_noise_deg_per_h));
  form.if_present("variance_in_training", std::isfinite(uncertainty.variance_in_training),
                  not_negative(uncertainty.variance_in_training));
}

}  // namespace gyrotherm::model
