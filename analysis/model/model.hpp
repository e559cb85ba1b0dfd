// SPDX-License-Identifier: Apache-2.0
/// A trained compensation model: what it takes in, how it computes, what is known of it, and what it predicts inside
/// and outside the range in which it was trained. It is kept in one JSON file.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/data/clusters.hpp"
#include "analysis/data/features.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/methods/method.hpp"
#include "analysis/model/budget.hpp"
#include "analysis/model/selection.hpp"
#include "analysis/svm/tuning.hpp"
#include "analysis/tracking/bias_noise.hpp"
#include "core/result.hpp"

namespace gyrotherm::model {

inline constexpr const char* kModelSchema = "gyrotherm-model/1";

/// The method of a model that was trained with a type prior (prior_training.hpp). It is none of the table's: those
/// learn from one unit's clusters alone.
inline constexpr const char* kTypePriorMethod = "type-prior";

/// The lowest and the highest mean of any thermometer of the block, °C.
struct BlockRange {
  double low_c{}, high_c{};
  bool operator==(const BlockRange&) const = default;
};

void describe(auto& form, Like<BlockRange> auto& range) {
  form("low_c", range.low_c);
  form("high_c", range.high_c);
  form.expect("high_c", range.high_c >= range.low_c, "expected no less than low_c");
}

/// A record that a model was trained on, and which part of it.
struct TrainingRecord {
  std::string run_id;
  std::string path;
  std::string profile_name;
  bool simulated{};
  int clusters{};
  double from_s{}, to_s{};            ///< start of its first cluster and end of its last, since that run started
  data::AxisChoice of{};              ///< empty: of a record that has one
  std::string identity{};             ///< which gyro that is, as far as the record says
  std::string bias_zero{};            ///< what its bias is counted from; empty: not known
  std::optional<BlockRange> block{};  ///< over those clusters
};

/// What it cost to make a model smaller.
struct ReducedSetSummary {
  int vectors_before{}, vectors{};
  double bound_deg_per_h{};       ///< no prediction, for any input, has changed by more
  double max_change_deg_per_h{};  ///< of the predictions on the training clusters
  double rms_change_deg_per_h{};
  int clusters{};  ///< how many those were
};

/// The lag of a stream of the model's predictions and its cost; see latency_of().
struct Latency {
  double lag_s{};                  ///< half the cluster length
  double lagging_rms_deg_per_h{};  ///< error over the training, not led
  double led_rms_deg_per_h{};      ///< error, led by half a cluster
  bool is_led{};                   ///< they are, since that is less
};

void describe(auto& form, Like<Latency> auto& latency) {
  form("lag_s", not_negative(latency.lag_s));
  form("lagging_rms_deg_per_h", not_negative(latency.lagging_rms_deg_per_h));
  form("led_rms_deg_per_h", not_negative(latency.led_rms_deg_per_h));
  form("is_led", latency.is_led);
}

struct Model {
  std::string program_version;
  std::string inputs;             ///< "multi-point", "multi-point-t", "three-point" or the terms as given
  std::string method;             ///< a name of the table of methods, or kTypePriorMethod
  double cluster_length_s = 100;  ///< of the means it was trained on
  std::vector<data::Term> terms;
  data::Scaling scaling;
  double target_mean_deg_per_h{};
  double target_std_deg_per_h{};
  methods::Function function;
  methods::HyperParameters hyper_parameters;  ///< as chosen on the held-out folds
  double effective_parameters{};              ///< of the function; see Fit
  double residual_std_deg_per_h{};  ///< √(RSS/(n − p)) in-sample, p the effective parameters; NaN if p ≥ n
  std::string particulars;          ///< see Fit
  std::optional<methods::PredictiveVariance> variance;  ///< see Fit; of the full function, if it has been reduced
  std::optional<ReducedSetSummary> reduction;  ///< of vectors; the figures below are those of the full function
  std::vector<TrainingRecord> trained_on;
  Selection selection;                ///< multi-point only
  svm::TuningSummary tuning;          ///< support vector methods only; else "was not run"
  svm::TuningOptions tuning_options;  ///< as used
  bool quick{};                       ///< tuned with a small swarm, for a try
  std::string folds;                  ///< "leave one cycle out (4)", "4 consecutive blocks"
  data::Figures in_sample;            ///< residual on the training clusters: not a verification
  data::Figures
      leave_cycle_out;  ///< each fold predicted by a model refitted without it, selection and scaling included
  std::optional<data::Figures> nested_leave_cycle_out;  ///< the same, hyper-parameters chosen without the fold too
  Eigen::VectorXd leave_cycle_out_residual;           ///< per training cluster, °/h (kept in the file for the report)
  std::optional<tracking::BiasNoise> residual_noise;  ///< of that residual, if it is long enough: for bias tracking
  Eigen::RowVectorXd input_min, input_max;            ///< trained range of each term, unscaled
  std::vector<std::string> warnings;
  std::optional<Latency> latency;          ///< measured over the training
  std::optional<Uncertainty> uncertainty;  ///< of what it leaves, as it was trained
};

/// Returns the range of the block over all training records; nothing where none has it.
[[nodiscard]] std::optional<BlockRange> trained_block(const std::vector<TrainingRecord>& records);
/// Returns "block −17 to 58 °C", in whole degrees that lie inside the range.
[[nodiscard]] std::string in_words(const BlockRange& range);

/// The numbers that the model's function, the scaling of its inputs and its target store.
[[nodiscard]] int stored_numbers(const Model& model);

/// Predicted bias of each cluster, °/h. Fails with usage if the clusters lack a thermometer that the model needs.
[[nodiscard]] Result<Eigen::VectorXd> predict(const Model& model, const data::Clusters& clusters);
/// Returns true if a stream of its predictions is led by half a cluster, p + ½(p − p a cluster before).
[[nodiscard]] inline bool is_led(const Model& model) { return model.latency && model.latency->is_led; }
/// The rows of one a second that make a mean over the model's cluster length: at least one.
[[nodiscard]] int rows_in_cluster(const Model& model);

/// Predicted bias of each row of unscaled inputs (rows × terms), °/h; NaN where an input is not finite.
[[nodiscard]] Eigen::VectorXd predict(const Model& model, const data::SampleMatrix& inputs);

/// A predicted bias of each row and the standard deviation of it as far as the model knows: of the function, without
/// the noise of a mean and without what the thermometers do after the training; °/h.
struct Prediction {
  Eigen::VectorXd bias_deg_per_h;
  Eigen::VectorXd std_deg_per_h;
};
/// The first record that the model was trained on and that is of another gyro than this; null: none says so.
[[nodiscard]] const TrainingRecord* trained_on_another(const Model& model, std::string_view identity);
/// … and that is of another axis of that unit; null: none says so, as where a unit has one axis.
[[nodiscard]] const TrainingRecord* trained_on_another_axis(const Model& model, const data::AxisChoice& of);
/// Both in words, as warnings, and whether the bias that it was trained on is counted from another zero: an empty
/// identity says nothing, nor does an empty zero.
[[nodiscard]] std::vector<std::string> warnings_of_origin(const Model& model, const data::AxisChoice& of,
                                                          std::string_view identity, std::string_view bias_zero);

/// Predicts rows of unscaled inputs (rows × terms). Fails with usage if the method of the model does not know its
/// variance.
[[nodiscard]] Result<Prediction> predict_with_std(const Model& model, const data::SampleMatrix& inputs);

/// What is done with inputs beyond the range in which a model was trained.
///
/// continued, the default: the plane of the function continues as a plane, and its other parts, Gaussians and hidden
/// units, are taken at the bounded point. Inputs that nearly repeat each other, as neighbouring thermometers do, keep
/// their differences that way; moving each input to its own nearer end would invent gradients. refuse: nothing is
/// predicted. extrapolate: the whole function is used as it is; Gaussians then die away within a few widths.
///
/// The bounded point lies on the straight line from the point to the training mean of its inputs, as far out as every
/// single factor allows. A product is made anew from its factors there if each factor is an input itself;
/// any other product is moved as an input of its own.
enum class Outside { continued, refuse, extrapolate };

[[nodiscard]] const char* name(Outside outside);
/// Reads the name of a policy. Fails with usage, naming the three.
[[nodiscard]] Result<Outside> parse_outside(std::string_view text);

/// Inputs of a model after the policy.
struct RangedInputs {
  data::SampleMatrix inputs;       ///< unscaled; with refuse, NaN in every row that is outside
  data::SampleMatrix bounded;      ///< points of all but the plane
  Eigen::VectorXd excess;          ///< worst_excess of each row
  std::vector<Eigen::Index> rows;  ///< those with an input outside, in order
  Eigen::Index worst_term = -1;    ///< the term that is farthest outside, as a part of its own range; −1: none is
  double worst_excess{};           ///< how far: 0.1 is a tenth of the term's trained range
};

/// Applies the policy to `inputs`, rows × terms of the model, unscaled. A row that holds a NaN is not outside and stays
/// NaN.
[[nodiscard]] RangedInputs within_range(const Model& model, data::SampleMatrix inputs, Outside outside);

/// Predicted bias of each row, °/h; NaN where an input is not finite.
[[nodiscard]] Eigen::VectorXd predict(const Model& model, const RangedInputs& ranged);

/// The factors of a product that are inputs themselves, as the bounded point needs them.
struct RemadeProduct {
  Eigen::Index term{};
  std::vector<Eigen::Index> factors{};
};
/// Returns the products among the terms all of whose factors are terms themselves, in order.
[[nodiscard]] std::vector<RemadeProduct> remade_products(const std::vector<data::Term>& terms);

// Fewer vectors at a stated loss: a sum of Gaussians projected onto those of a few of its centres.
//
// In the space of the kernel the function f = Σ β_i k(x_i, ·) is nearest to the span of the centres kept, R, at
// K_RR β′ = K_R· β (Burges 1996; Schölkopf et al. 1999, §III). Centres are taken one by one, each time the one that
// then leaves the least: the residual at it, squared, over what of its own kernel function the others do not span
// (orthogonal matching pursuit; a pivoted Cholesky factorisation guided by the residual). Since k(z, z) = 1, the norm
// of what is left bounds the change at every z.

/// How far a model is to be reduced; exactly one of the two is given.
struct ReducedSetGoal {
  std::optional<int> vectors = {};                  ///< at most so many, at least 1
  std::optional<double> max_change_deg_per_h = {};  ///< as few as keep every training cluster within this, above 0
};

/// Returns the model with fewer vectors, its `reduction` set and all else as it was: its figures are those of the full
/// function. Where all vectors are needed it keeps them as they are, at no loss. Fails with usage: a goal that is none,
/// a function that is no sum of Gaussians of one width, a model that has been reduced before, clusters without its
/// thermometers or without a value.
[[nodiscard]] Result<Model> reduce(const Model& model, const data::Clusters& training, const ReducedSetGoal& goal);

/// The model file.
[[nodiscard]] std::string to_json(const Model& model);
/// Reads a model file. Fails with bad_file: syntax, schema, missing or non-finite numbers, lengths that do not fit; the
/// place is file:line:column for syntax and the JSON path for content.
[[nodiscard]] Result<Model> model_from_json(std::string_view json, const std::string& file);

}  // namespace gyrotherm::model
