// SPDX-License-Identifier: Apache-2.0
/// The report of an experiment as data. All views, including the file report.json, are made only from these data.
///
/// The same inputs always give the same report: it contains no wall-clock time, thread count or path of the machine.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/data/allan.hpp"
#include "analysis/data/clusters.hpp"
#include "analysis/data/hold_noise.hpp"
#include "analysis/data/statistics.hpp"
#include "analysis/model/characterisation.hpp"
#include "analysis/model/qualification.hpp"
#include "analysis/model/verification.hpp"
#include "core/result.hpp"
#include "report/thermal_model.hpp"

namespace gyrotherm::report {

inline constexpr const char* kReportSchema = "gyrotherm-report/1";
/// A number that is unknown or does not apply; null in the file.
inline constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

/// A thermometer channel with its instrument and the correction of its readings.
struct ReportedThermometer {
  std::string channel;
  std::string instrument;
  /// "offset 0.01 K, certificate 2026-0123, due 2027-03-01", or "none".
  std::string calibration;
};

struct ReportedRig {
  std::string name;
  std::string title;
  std::string gyro;  ///< "pulse counts, 0.1 arcsec each"
  /// Hash of the rig file.
  std::string sha256;
  /// The results are marked as SIMULATED: the rig is virtual, or some of its instruments are.
  bool is_virtual{};
  /// Thermal model of a virtual gyro; may be empty.
  std::string gyro_model;
  std::string gyro_film;  ///< surrounding air: "chamber", "still"
  /// Hash of the model file.
  std::string gyro_model_sha256;
  std::vector<ReportedThermometer> thermometers;
};

/// A limit of the profiles' [accept] tables and the value compared with it.
struct AcceptedLimit {
  /// Key in the report: "random.multi_point_t.std_deg_per_h".
  std::string figure;
  double limit{};
  double value{};
  bool passed{};
};

/// Correlation of the bias with each gradient, temperature and temperature rate, and the selected gradients.
struct ReportedCorrelation {
  std::vector<std::string> names;              ///< thermometers, in matrix order
  std::vector<std::vector<double>> magnitude;  ///< |r|, symmetric, zero diagonal
  /// Signed r, with rows and columns as above.
  std::vector<std::vector<double>> gradient;
  std::vector<double> temperature, rate;
  std::vector<std::string> selected_pairs;
  double threshold{};
  int rank{};
  /// True if too few gradients exceeded the threshold, so the fallback rule selected the inputs.
  bool fallback{};
  std::string statement;  ///< remark on the selection
};

/// Residual bias of a record after compensation.
struct ReportedResidual {
  data::Figures all, ramps, holds, corners;
  std::optional<model::TrueBiasError> to_truth;  ///< virtual rig only
  model::RangeExceedance outside;
  double effective_parameters = kNotKnown;
  /// Unknown for a record that was not used in training.
  double expected_in_sample_std = kNotKnown;
  std::optional<model::StreamResult> streamed;  ///< result of a second-by-second stream
};

struct ReportedCycle {
  std::string name;
  double start_s{}, end_s{};
};

/// Time series for the figures, one value per cluster.
struct ReportedSeries {
  std::vector<double> time_s, set_point_c, raw;
  std::vector<std::pair<std::string, std::vector<double>>> thermometers_c;
  model::PerModel<std::vector<double>> residual;
  std::vector<ReportedCycle> cycles;
};

/// Noise during the holds and Allan deviation of the whole run, before and after compensation.
struct ReportedNoise {
  /// Noise of the holds, uncompensated and compensated by multi_point_t.
  data::HoldNoise holds, compensated_holds;
  data::AllanCurve raw;
  model::PerModel<data::AllanCurve> compensated;
};

/// Improvement by a model, as fractions. The last two values are relative to three-point and unknown for three-point.
struct ReportedGain {
  double from_original{}, paper_ratio = kNotKnown, residual_reduction = kNotKnown;
};

/// One record and the results of the three models on it.
struct ReportedRun {
  /// True if the record was used to train a model.
  bool in_sample{};
  std::string profile, run_id, bias_zero;
  std::string record_sha256;         ///< digest of the rows as `export` writes them
  std::string record_file_sha256{};  ///< digest of the file; empty if unknown
  std::string profile_sha256;
  data::NoiseFloor floor;
  int clusters{}, dropped_rest{}, dropped_gaps{};
  std::vector<std::pair<double, double>> gaps_s;
  /// Raw bias of the clusters with a residual of each of the three models.
  data::Figures raw;
  model::PerModel<ReportedResidual> residual;
  model::PerModel<ReportedGain> gain;
  ReportedNoise noise;
  model::Characterisation characterisation;  ///< "after" is compensated by multi_point_t
  ReportedSeries series;
};

struct ReportedTraining {
  std::string run_id, profile;
  bool simulated{};
  int clusters{};
  std::optional<model::BlockRange> block{};
};

/// One of the three models: its inputs, the tuning of its parameters, and the optimality certificate of the solution.
struct ReportedModel {
  std::string inputs, method;
  std::vector<std::string> terms;
  int rank{}, stored_numbers{};
  double effective_parameters = kNotKnown, residual_std_deg_per_h = kNotKnown;
  std::vector<ReportedTraining> trained_on;
  svm::TuningOptions options;
  svm::TuningSummary tuning;
  svm::SvrParameters parameters;
  double epsilon_deg_per_h{};
  int support_vectors{};
  double certified_gap{}, kkt_violation{};
  std::string folds;
  std::optional<model::Uncertainty> uncertainty;  ///< budget of a 1 h mean
};

/// Combined uncertainty from the budget of a 1 h mean.
struct ReportedUncertainty {
  double standard_deg_per_h{}, coverage_factor{}, expanded_deg_per_h{};  ///< u, k, U = k·u
  /// Sensitivity of the compensated bias to the thermometers: root sum of squares of the RMS sensitivity to each.
  double sensitivity_deg_per_h_per_k{};
};

/// Result of a method on a record that was not used in training.
struct ReportedVerification {
  data::Figures figures;
  std::optional<model::TrueBiasError> to_truth;  ///< virtual rig only
  std::optional<model::Coverage> coverage;       ///< intervals of the method's budget
};

/// A later record of the same gyro, used to check whether the models remain valid.
struct ReportedLaterRun {
  std::string name;  ///< "30 days later", or the file name
  std::string profile, run_id, record_sha256;
  data::NoiseFloor floor;
  /// Raw bias of the clusters with a residual of the multi-point model.
  data::Figures raw;
};

/// A method and its results on the same records.
struct ReportedMethod {
  std::string name;  ///< "linear-multi-point-t"
  std::string inputs, method;
  std::string title;     ///< "PSO-SVM"
  std::string citation;  ///< publication of the method
  data::Figures in_sample, leave_cycle_out;
  /// Leave-cycle-out errors, where the hyper-parameters were also chosen without the held-out cycle.
  std::optional<data::Figures> nested;
  ReportedVerification random;
  std::vector<ReportedVerification> later;        ///< in the order of Report::later
  std::optional<model::RunScatter> between_runs;  ///< random and later runs
  std::optional<ReportedUncertainty> uncertainty;
  /// Size of the model for a navigation computer; 0 if unknown.
  int stored_numbers{};
  double effective_parameters = kNotKnown;
};

struct ReportedSegment {
  std::string run;  ///< "rate" or "random"
  int segment{};
  std::string name;
  bool hold{};
  double start_s{}, duration_s{}, mean_temperature_c{}, mean_bias_deg_per_h{};
  model::PerModel<data::Figures> residual;
};

struct Report {
  ReportedRig rig;
  ReportedThermal thermal;
  bool quick{};
  std::vector<AcceptedLimit> accept;  ///< empty: no limit in the profiles
  double cluster_length_s{};
  /// From the clusters of the ramp run and the gradient thermometers.
  ReportedCorrelation correlation;
  ReportedRun rate, random;
  std::string folds;
  model::PerModel<data::Figures> leave_cycle_out;
  model::PerModel<std::optional<data::Figures>> nested_leave_cycle_out;
  model::PerModel<ReportedModel> models;
  std::vector<ReportedLaterRun> later;
  std::vector<ReportedMethod> methods;  ///< the three models and all others
  model::Recommendation recommendation;
  std::vector<std::string> warnings;
  std::vector<ReportedSegment> segments;
  std::string program_version;
  std::uint64_t seed{};
  /// Virtual rig: days by which the gyro has aged before both runs.
  std::uint64_t days_later{};
};

/// Returns "PASS", "FAIL" or "no limit".
[[nodiscard]] std::string overall_verdict(const Report& report);

/// Returns "in-sample: the models were fitted to these data" or "not used to train any model".
[[nodiscard]] const char* in_sample_text(const ReportedRun& run);

/// Returns report.json, ending in a newline. Each top-level key is on a separate line, so reports can be compared by
/// line. Numbers have the fewest digits that restore the same double; NaN is null.
[[nodiscard]] std::string to_json(const Report& report);

/// Reads report.json. Fails with bad_file on syntax errors (where: file:line:column), and on another schema, a missing
/// key, a wrong type or a wrong length (where: path of the key).
[[nodiscard]] Result<Report> read_report(std::string_view json, const std::string& file);

/// An upper limit for a value of the report.
struct Limit {
  std::string figure;
  double at_most{};
};

/// Checks that reports contain a value named `figure` that can have a limit. Otherwise fails with usage and suggests
/// the nearest name.
[[nodiscard]] Result<void> check_limit(const std::string& figure);

/// Compares the values of a report with limits that check_limit() accepted.
[[nodiscard]] std::vector<AcceptedLimit> compare_with_limits(const Report& report, const std::vector<Limit>& limits);

// Assembly of the report from the records of an experiment and the models trained on them

/// A record of the experiment with its hashes.
struct ReportSourceRun {
  const data::RecordedRun& recorded;
  std::string record_sha256;  ///< digest of the rows as `export` writes them
  std::string profile_sha256;
  std::string record_file_sha256{};  ///< digest of the file; empty if unknown
};

/// A later record of the same gyro.
struct ReportSourceLater {
  std::string name;
  const data::RecordedRun& recorded;
  std::string record_sha256;
};

struct ReportSource {
  ReportedRig rig;
  ReportedThermal thermal{};
  ReportSourceRun rate, random;
  /// Records passed to verify_later(), in the same order.
  std::vector<ReportSourceLater> later;
  /// Qualification on exactly these records; its three models are SVRs.
  const model::Qualification& qualification;
  std::string program_version;
  std::uint64_t seed{};
  /// Virtual rig: days by which the gyro has aged before both runs.
  std::uint64_t days_later{};
};

/// Returns the report without limits. Asserts that the models are SVRs and that the verifications fit their clusters.
[[nodiscard]] Report make_report(const ReportSource& source);

}  // namespace gyrotherm::report
