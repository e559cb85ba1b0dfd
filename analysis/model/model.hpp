// SPDX-License-Identifier: Apache-2.0
/// A trained compensation model: its inputs and function, its accuracy, and its predictions inside and outside the
/// trained range. It is stored in one JSON file.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "analysis/data/rate_trace.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/methods/method.hpp"
#include "analysis/model/budget.hpp"
#include "analysis/model/power_on_constants.hpp"
#include "analysis/model/selection.hpp"
#include "analysis/model/verdict.hpp"
#include "analysis/svm/tuning.hpp"
#include "analysis/tracking/bias_noise.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

inline constexpr const char* kModelSchema = "gyrotherm-model/1";

/// Method name of a model that was trained with a type prior (prior_training.hpp). The table of methods does not
/// contain it, since the methods in the table learn only from the clusters of one unit.
inline constexpr const char* kTypePriorMethod = "type-prior";

/// Lowest and highest cluster mean of a thermometer that is not on the block, °C.
struct ThermometerRange {
  std::string thermometer{};
  double low_c{}, high_c{};
  bool operator==(const ThermometerRange&) const = default;
};

void describe(auto& form, Like<ThermometerRange> auto& range) {
  form("thermometer", range.thermometer);
  form("low_c", range.low_c);
  form("high_c", range.high_c);
  form.expect("high_c", range.high_c >= range.low_c, "expected no less than low_c");
}

/// Lowest and highest cluster mean of the block's thermometers (data::block_thermometers()), °C.
struct BlockRange {
  double low_c{}, high_c{};
  std::vector<std::string> thermometers{};  ///< empty: not stated by the model
  /// Other temperatures among the inputs, such as that of the shell.
  std::vector<ThermometerRange> others{};
  bool operator==(const BlockRange&) const = default;
};

void describe(auto& form, Like<BlockRange> auto& range) {
  form("low_c", range.low_c);
  form("high_c", range.high_c);
  form.if_present("thermometers", !range.thermometers.empty(), range.thermometers);
  form.if_present("others", !range.others.empty(), range.others);
  form.expect("high_c", range.high_c >= range.low_c, "expected no less than low_c");
}

/// A record that a model was trained on, and the period of it that was used.
struct TrainingRecord {
  std::string run_id;
  std::string path;
  std::string profile_name;
  bool simulated{};
  int clusters{};
  /// Start of the first cluster and end of the last one since the start of the run.
  double from_s{}, to_s{};
  /// Unit and axis in the record; empty for a record with a single axis.
  data::AxisChoice of{};
  /// Identity of the gyro, as far as the record states it.
  std::string identity{};
  /// Bias reference; empty if unknown.
  std::string bias_zero{};
  /// Temperature range of the block over the clusters used.
  std::optional<BlockRange> block{};
  /// data::trace_rates() of a record that was imported or is not simulated; nothing for any other record.
  std::optional<data::RateTrace> rate_trace{};
};

/// The loss of accuracy caused by the reduction of a model.
struct ReducedSetSummary {
  int vectors_before{}, vectors{};
  /// Upper bound of the change of any prediction, for every input.
  double bound_deg_per_h{};
  /// Greatest change of the predictions on the training clusters.
  double max_change_deg_per_h{};
  double rms_change_deg_per_h{};
  int clusters{};  ///< training clusters
};

/// The lag of the model's predictions in a stream, and the error that it causes; see measure_latency().
struct Latency {
  /// Half the cluster length.
  double lag_s{};
  /// RMS of the training residual if a stream does not extrapolate its predictions.
  double lagging_rms_deg_per_h{};
  /// RMS of the training residual if a stream extrapolates its predictions by half a cluster.
  double led_rms_deg_per_h{};
  /// Set if predictions are extrapolated because this reduces the error.
  bool is_led{};
};

void describe(auto& form, Like<Latency> auto& latency) {
  form("lag_s", not_negative(latency.lag_s));
  form("lagging_rms_deg_per_h", not_negative(latency.lagging_rms_deg_per_h));
  form("led_rms_deg_per_h", not_negative(latency.led_rms_deg_per_h));
  form("is_led", latency.is_led);
}

struct Model {
  std::string program_version;
  /// "multi-point", "multi-point-t", "three-point", or the terms as given.
  std::string inputs;
  /// Name in the table of methods, or kTypePriorMethod.
  std::string method;
  /// Length of the training means.
  double cluster_length_s = 100;
  std::vector<data::Term> terms;
  data::Scaling scaling;
  double target_mean_deg_per_h{};
  double target_std_deg_per_h{};
  methods::Function function;
  /// Hyper-parameters chosen on the held-out folds.
  methods::HyperParameters hyper_parameters;
  /// Effective parameters of the function; see Fit.
  double effective_parameters{};
  /// √(RSS/(n − p)) in-sample, p the effective parameters; NaN if p ≥ n.
  double residual_std_deg_per_h{};
  std::string particulars;  ///< see Fit
  /// See Fit. If the model was reduced, the variance still belongs to the full function.
  std::optional<methods::PredictiveVariance> variance;
  /// Reduction of the vectors. The members below describe the full function.
  std::optional<ReducedSetSummary> reduction;
  std::vector<TrainingRecord> trained_on;
  /// Power-ons of the training records, with the constants that were subtracted; empty if there was only one.
  std::vector<PowerOn> power_ons;
  Selection selection;        ///< multi-point only
  svm::TuningSummary tuning;  ///< "was not run" for other methods
  svm::TuningOptions tuning_options;
  /// True if the tuning used a small swarm, for a quick trial.
  bool quick{};
  std::string folds;  ///< "leave one cycle out (4)", "4 consecutive blocks"
  /// Residual on the training clusters without the constants of their power-ons, which is not a verification.
  data::Figures in_sample;
  /// Each fold is predicted by a model that was refitted without it, including selection and scaling.
  data::Figures leave_cycle_out;
  /// Like leave_cycle_out, with hyper-parameters that were also chosen without the fold.
  std::optional<data::Figures> nested_leave_cycle_out;
  /// Verdict on the held-out residual against the raw bias; of the nested one if there is one. Empty in a file of an
  /// earlier version.
  std::optional<Verdict> verdict;
  /// Leave-cycle-out residual of each training cluster, °/h. The model file stores it for the report.
  Eigen::VectorXd leave_cycle_out_residual;
  /// Noise of leave_cycle_out_residual for bias tracking, if the residual is long enough.
  std::optional<tracking::BiasNoise> residual_noise;
  /// Trained range of each term, unscaled.
  Eigen::RowVectorXd input_min, input_max;
  std::vector<std::string> warnings;
  /// Lag of a stream, measured on the training clusters.
  std::optional<Latency> latency;
  /// Uncertainty of the residual bias at the time of training.
  std::optional<Uncertainty> uncertainty;
};

/// Returns the range of the block over all training records; no value if no record has one.
[[nodiscard]] std::optional<BlockRange> trained_block(const std::vector<TrainingRecord>& records);
/// Returns the range as text, rounded inwards to whole degrees: "block −17 to 58 °C (A, B), shell −30 to 60 °C".
[[nodiscard]] std::string describe(const BlockRange& range);

/// Returns the number of parameters that the model stores for its function, its inputs' scaling and its target.
[[nodiscard]] int stored_numbers(const Model& model);

/// Predicts the bias of each cluster, °/h. Fails with usage if the clusters lack a thermometer that the model needs.
[[nodiscard]] Result<Eigen::VectorXd> predict(const Model& model, const data::Clusters& clusters);
/// Returns true if a stream extrapolates its predictions by half a cluster: p + ½(p − p one cluster before).
[[nodiscard]] inline bool is_led(const Model& model) { return model.latency && model.latency->is_led; }
/// Returns the number of one-second rows in a mean over the model's cluster length, at least one.
[[nodiscard]] int rows_in_cluster(const Model& model);

/// Predicts the bias of each row of unscaled inputs (rows × terms), °/h; NaN if an input is not finite.
[[nodiscard]] Eigen::VectorXd predict(const Model& model, const data::SampleMatrix& inputs);

/// Predicted bias of each row and its standard deviation, °/h. The standard deviation covers the uncertainty of the
/// function; it excludes the noise of a mean and the thermometers' drift since the training.
struct Prediction {
  Eigen::VectorXd bias_deg_per_h;
  Eigen::VectorXd std_deg_per_h;
};
/// Returns the first training record that belongs to a gyro other than `identity`; null if no record states another
/// identity.
[[nodiscard]] const TrainingRecord* find_other_gyro(const Model& model, std::string_view identity);
/// Returns the first training record that belongs to another axis of this unit; null if no record states another axis.
[[nodiscard]] const TrainingRecord* find_other_axis(const Model& model, const data::AxisChoice& of);
/// Origin of the biases to which a model is applied. An empty member is unknown.
struct Origin {
  data::AxisChoice of{};
  std::string identity{}, bias_zero{}, run_id{};
};
[[nodiscard]] Origin find_origin(const data::Dataset& dataset);

/// Returns warnings for a model of another gyro, of another axis, or of a bias with another zero. The zero also differs
/// if the model and the record each refer to the mean of their own first hold. An unknown identity or reference causes
/// no warning.
[[nodiscard]] std::vector<std::string> origin_warnings(const Model& model, const Origin& origin);

/// Predicts rows of unscaled inputs (rows × terms). Fails with usage if the model has no predictive variance.
[[nodiscard]] Result<Prediction> predict_with_std(const Model& model, const data::SampleMatrix& inputs);

/// Policy for inputs outside the trained range of a model.
///
/// - continued (the default): the plane of the function continues; its other parts, Gaussians and hidden units, are
///   evaluated at the bounded point. Nearly equal inputs, such as neighbouring thermometers, keep their differences
///   there; clipping each input to its own range would create gradients that do not exist.
/// - refuse: no prediction.
/// - extrapolate: the function is evaluated unchanged; Gaussians vanish within a few widths.
///
/// The bounded point is on the straight line from the point to the training mean of the inputs, as far out as the range
/// of every single factor permits. A product is recomputed from its factors there if each factor is an input itself;
/// any other product is moved like an input.
enum class Outside { continued, refuse, extrapolate };

[[nodiscard]] const char* name(Outside outside);
/// Parses the name of a policy. Fails with usage; the message lists the three names.
[[nodiscard]] Result<Outside> parse_outside(std::string_view text);

/// Inputs of a model after applying the policy.
struct RangedInputs {
  /// Unscaled inputs. With refuse, every row that is outside is NaN.
  data::SampleMatrix inputs;
  /// Inputs moved to the bounded point (see Outside). The plane of a model uses `inputs`, all other parts use
  /// `bounded`.
  data::SampleMatrix bounded;
  /// Worst excess of each row.
  Eigen::VectorXd excess;
  /// Rows with an input outside, in ascending order.
  std::vector<Eigen::Index> rows;
  /// Index of the term farthest outside, relative to its own range; −1 if no term is outside.
  Eigen::Index worst_term = -1;
  /// Excess of that term: 0.1 is a tenth of its trained range.
  double worst_excess{};
};

/// Applies the policy to `inputs` (rows × terms of the model, unscaled). A row with a NaN is not treated as outside and
/// remains unchanged.
[[nodiscard]] RangedInputs apply_range_policy(const Model& model, data::SampleMatrix inputs, Outside outside);

/// Predicts the bias of each row, °/h; NaN if an input is not finite.
[[nodiscard]] Eigen::VectorXd predict(const Model& model, const RangedInputs& ranged);

/// A product whose factors are all inputs themselves, for the bounded point.
struct RecomputedProduct {
  Eigen::Index term{};
  std::vector<Eigen::Index> factors{};
};
/// Returns the product terms whose factors are all terms themselves, in order.
[[nodiscard]] std::vector<RecomputedProduct> recomputed_products(const std::vector<data::Term>& terms);

// Reduction of a sum of Gaussians to fewer vectors with a stated loss, by projection onto the Gaussians of a few of its
// centres.
//
// In the space of the kernel, the function f = Σ β_i k(x_i, ·) is nearest to the span of the kept centres, R, at K_RR
// β′ = K_R· β (Burges 1996; Schölkopf et al. 1999, §III). Centres are added one at a time. The next centre is the one
// that leaves the smallest residual: its squared residual, divided by the squared norm of the part of its kernel
// function that the kept centres do not span, is the greatest (orthogonal matching pursuit; a pivoted Cholesky
// factorisation guided by the residual). Since k(z, z) = 1, the norm of the residual bounds the change at every z.

/// Target of a reduction; exactly one of the two is given.
struct ReducedSetGoal {
  /// Greatest number of vectors, at least 1.
  std::optional<int> vectors = {};
  /// Greatest permitted change of the prediction for any training cluster, above 0. The reduction uses the fewest
  /// vectors that meet it.
  std::optional<double> max_change_deg_per_h = {};
};

/// Returns the model with fewer vectors and `reduction` set. All other members stay those of the full function. If all
/// vectors are needed, they are kept without loss. Fails with usage: an invalid goal, a function other than a sum of
/// Gaussians of one width, a model that has been reduced before, clusters without its thermometers or without a value.
[[nodiscard]] Result<Model> reduce(const Model& model, const data::Clusters& training, const ReducedSetGoal& goal);

/// Formats a model file.
[[nodiscard]] std::string to_json(const Model& model);
/// Parses a model file. Fails with bad_file: syntax, schema, missing or non-finite numbers, lengths that do not match.
/// The location is file:line:column for syntax and the JSON path for content.
[[nodiscard]] Result<Model> model_from_json(std::string_view json, const std::string& file);

}  // namespace gyrotherm::model
