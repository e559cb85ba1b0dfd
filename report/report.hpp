// SPDX-License-Identifier: Apache-2.0
/// The report of an experiment as data: every view of it, the file report.json first, is made of this alone.
///
/// Equal inputs give equal bytes: nothing in it varies from run to run of the same experiment, so no wall time, no
/// thread count and no path of the machine.
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
/// Stands for a number that is not known, or that does not apply; null in the file.
inline constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

/// Who reads a channel, and how its readings were corrected, in words.
struct ReportedThermometer {
  std::string channel;
  std::string instrument;
  std::string calibration;  ///< "offset 0.01 K, certificate 2026-0123, due 2027-03-01", "none"
};

struct ReportedRig {
  std::string name;
  std::string title;
  std::string gyro;    ///< in words: "pulse counts, 0.1 arcsec each"
  std::string sha256;  ///< of the rig file
  bool is_virtual{};
  std::string gyro_model;         ///< the thermal model that a virtual gyro stands on; may be empty
  std::string gyro_film;          ///< how the air moves around it: "chamber", "still"
  std::string gyro_model_sha256;  ///< of the model's file
  std::vector<ReportedThermometer> thermometers;
};

/// One limit of the profiles' [accept] tables and the figure held against it.
struct AcceptedLimit {
  std::string figure;  ///< its key in the report: "random.multi_point_t.std_deg_per_h"
  double limit{};
  double value{};
  bool passed{};
};

/// How the bias goes with each gradient, temperature and temperature rate, and what was selected of that.
struct ReportedCorrelation {
  std::vector<std::string> names;              ///< thermometers, rows and columns of `gradient`
  std::vector<std::vector<double>> magnitude;  ///< |r|, symmetric, with a zero diagonal
  std::vector<std::vector<double>> gradient;   ///< signed r
  std::vector<double> temperature, rate;
  std::vector<std::string> selected_pairs;
  double threshold{};
  int rank{};
  bool fallback{};
  std::string statement;
};

/// What a model leaves of a record's bias.
struct ReportedResidual {
  data::Figures all, ramps, holds, corners;
  std::optional<model::ErrorToTruth> to_truth;  ///< a virtual rig's
  model::OutsideTheRange outside;
  double effective_parameters = kNotKnown;
  double expected_in_sample_std = kNotKnown;  ///< not known also where the record was not trained on
  std::optional<model::Streamed> streamed;    ///< second by second
};

struct ReportedCycle {
  std::string name;
  double start_s{}, end_s{};
};

/// What the figures draw: a value per cluster each.
struct ReportedSeries {
  std::vector<double> time_s, set_point_c, raw;
  std::vector<std::pair<std::string, std::vector<double>>> thermometers_c;
  model::PerModel<std::vector<double>> residual;
  std::vector<ReportedCycle> cycles;
};

/// Of the holds, and of the whole run before and after compensation.
struct ReportedNoise {
  data::HoldNoise holds, compensated_holds;  ///< the latter of what multi_point_t leaves
  data::AllanCurve raw;
  model::PerModel<data::AllanCurve> compensated;
};

/// What a model gains: the last two over three-point, not known of it itself.
struct ReportedGain {
  double from_original{}, paper_ratio = kNotKnown, residual_reduction = kNotKnown;
};

/// One record and how each of the three models does on it.
struct ReportedRun {
  bool in_sample{};  ///< a model was trained on it
  std::string profile, run_id, bias_zero, record_sha256, profile_sha256;
  data::NoiseFloor floor;
  int clusters{}, dropped_rest{}, dropped_gaps{};
  std::vector<std::pair<double, double>> gaps_s;
  data::Figures raw;
  model::PerModel<ReportedResidual> residual;
  model::PerModel<ReportedGain> gain;
  ReportedNoise noise;
  model::Characterisation characterisation;  ///< after: what multi_point_t leaves
  ReportedSeries series;
};

struct ReportedTraining {
  std::string run_id, profile;
  bool simulated{};
  int clusters{};
  std::optional<model::BlockRange> block{};
};

/// One of the three models: what it takes in, how the swarm found its parameters, and the certificate of the result.
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
  std::optional<model::Uncertainty> uncertainty;  ///< with the budget of a mean over 1 h
};

/// What the budget of a mean over 1 h comes to.
struct ReportedUncertainty {
  double standard_deg_per_h{}, coverage_factor{}, expanded_deg_per_h{};  ///< u, k, U = k·u
  double sensitivity_deg_per_h_per_k{};  ///< to its thermometers: root sum of squares, each by its root mean square
};

/// How a method does on a record that it was not trained on.
struct ReportedVerification {
  data::Figures figures;
  std::optional<model::ErrorToTruth> to_truth;  ///< a virtual rig's
  std::optional<model::Coverage> coverage;      ///< of the intervals that its own budget gives
};

/// A record of the same gyro, made later than the two of the experiment: whether a model lasts.
struct ReportedLaterRun {
  std::string name;  ///< "30 days later", or the record's file
  std::string profile, run_id, record_sha256;
  data::NoiseFloor floor;
  data::Figures raw;
};

/// A method on the same records as the others.
struct ReportedMethod {
  std::string name;  ///< "linear-multi-point-t"
  std::string inputs, method;
  std::string title;     ///< "PSO-SVM"
  std::string citation;  ///< of its published form
  data::Figures in_sample, leave_cycle_out;
  std::optional<data::Figures> nested;  ///< leave-cycle-out with the parameters chosen without the held-out cycle too
  ReportedVerification random;
  std::vector<ReportedVerification> later;         ///< in the order of Report.later
  std::optional<model::BetweenRuns> between_runs;  ///< of the random run and the later ones
  std::optional<ReportedUncertainty> uncertainty;
  int stored_numbers{};  ///< its size in a navigation computer; 0: not known
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
  std::vector<AcceptedLimit> accept;  ///< empty: the profiles set no limit
  double cluster_length_s{};
  ReportedCorrelation correlation;  ///< of the rate run's clusters, over the gradient thermometers
  ReportedRun rate, random;
  std::string folds;
  model::PerModel<data::Figures> leave_cycle_out;
  model::PerModel<std::optional<data::Figures>> nested_leave_cycle_out;
  model::PerModel<ReportedModel> models;
  std::vector<ReportedLaterRun> later;
  std::vector<ReportedMethod> methods;   ///< the three models, and all that are compared with them
  model::Recommendation recommendation;  ///< by its rule, of `methods`
  std::vector<std::string> warnings;
  std::vector<ReportedSegment> segments;
  std::string program_version;
  std::uint64_t seed{};
  std::uint64_t days_later{};  ///< virtual rig: of both runs
};

/// "PASS", "FAIL" or "no limit".
[[nodiscard]] std::string verdict_of(const Report& report);

/// "in-sample: the models were fitted to these data" or "not seen by any model", for words beside a figure.
[[nodiscard]] const char* standing(const ReportedRun& run);

/// The text of report.json, ending in a newline: each key of the first level on a line of its own, so that two reports
/// can be compared line by line. Numbers have the fewest digits that give back the same double; NaN is null.
[[nodiscard]] std::string to_json(const Report& report);

/// Fails with bad_file on syntax (place: file:line:column), another schema, a missing key, a wrong type or lengths that
/// do not fit (place: the key's path).
[[nodiscard]] Result<Report> read_report(std::string_view json, const std::string& file);

/// A figure of the report and the greatest value at which it passes.
struct Limit {
  std::string figure;
  double at_most{};
};

/// Fails with usage, naming the nearest, if the report has no figure of that name that a limit can be set on.
[[nodiscard]] Result<void> check_limit(const std::string& figure);

/// The figures that limits name, held against them. The limits have been checked.
[[nodiscard]] std::vector<AcceptedLimit> held_against(const Report& report, const std::vector<Limit>& limits);

// How it is made of the records of an experiment and of what was trained on them.

/// A record of the experiment, and what it is known by.
struct ReportSourceRun {
  const data::RecordedRun& recorded;
  std::string record_sha256;
  std::string profile_sha256;
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
  std::vector<ReportSourceLater> later;       ///< those that verify_later() was given, in its order
  const model::Qualification& qualification;  ///< of exactly these records; its three models are SVRs
  std::string program_version;
  std::uint64_t seed{};
  std::uint64_t days_later{};  ///< virtual rig: of both runs
};

/// The report without limits. Asserts that models are SVRs, and that verifications fit their clusters.
[[nodiscard]] Report make_report(const ReportSource& source);

}  // namespace gyrotherm::report
