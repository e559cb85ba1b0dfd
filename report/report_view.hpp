/// What the views of the report read back from report.json: plain structs, complete or not there at all.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/data/statistics.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// The residual of one model on one record.
struct ResidualView {
  Figures all, ramps, holds, corners;
  double effective_parameters{}, expected_in_sample_std{};  ///< NaN: not known, or the record was not trained on
  std::string outside_policy, outside_farthest_term;
  int outside{};
  double outside_farthest{};
};

/// One value per model.
template <class T>
struct PerModel {
  T three_point;
  T multi_point;
  T multi_point_t;
};

struct SeriesView {
  std::vector<double> time_h, set_point_c, raw;
  std::vector<std::pair<std::string, std::vector<double>>> thermometers_c;
  PerModel<std::vector<double>> compensated;
  struct Cycle {
    std::string name;
    double start_h{}, end_h{};
  };
  std::vector<Cycle> cycles;
};

struct GainView {
  double from_original{}, paper_ratio{}, residual_reduction{};  ///< the last two NaN for three-point
};

/// One averaging time of an Allan curve.
struct AllanPointView {
  double tau_s{}, deviation_deg_per_h{}, error_deg_per_h{};
};
using AllanCurveView = std::vector<AllanPointView>;

/// One of Q, N, B, K, R; value and error NaN if it is not seen, read_off_s NaN for B.
struct NoiseView {
  std::string symbol, name, unit, formula;
  double read_off_s{};
  bool seen{};
  double value{}, error{}, at_most{};
};

/// The noise of the holds of a record, raw or compensated.
struct HoldNoiseView {
  std::string statement;
  AllanCurveView curve;
  std::vector<double> fitted_deg_per_h;  ///< at the points of the curve
  std::vector<NoiseView> coefficients;
  double lowest_tau_s{}, misfit{};
};

/// The noise of a record: of its holds, and of the whole run before and after compensation.
struct AllanView {
  HoldNoiseView holds, compensated_holds;
  AllanCurveView raw;
  PerModel<AllanCurveView> compensated;
};

struct RunView {
  bool in_sample{};
  std::string profile, run_id, bias_zero, record_sha256, profile_sha256;
  double noise_floor_deg_per_h{}, noise_floor_error_deg_per_h{};
  int noise_floor_differences{};
  int clusters{}, dropped_rest{}, dropped_gaps{}, gaps{};
  Figures raw;
  PerModel<ResidualView> residual;
  PerModel<GainView> gain;
  SeriesView series;
  AllanView allan;
};

struct ModelView {
  std::string inputs, method, trained_on;
  std::vector<std::string> terms;
  int rank{};
  int trained_clusters{};
  int stored_numbers{};
  double effective_parameters{};  ///< NaN: not known
  double C{}, sigma{}, epsilon{}, epsilon_deg_per_h{};
  int support_vectors{};
  double certified_gap{}, kkt_violation{};
  std::vector<double> history;
  int particles{}, iterations{}, evaluations{};
  std::string swarm_end;
  std::string seed;
  std::pair<double, double> log2_c, log2_sigma, log2_epsilon;
  double fixed_epsilon{};
};

struct CorrelationView {
  std::vector<std::string> names;
  std::vector<std::vector<double>> magnitude;
  std::vector<double> temperature, rate;
  std::vector<std::string> selected_pairs;
  double threshold{};
  int rank{};
  bool fallback{};
  std::string statement;
};

struct MethodView {
  std::string inputs, method, title, citation;
  Figures in_sample, leave_cycle_out, random;
  std::optional<Figures> nested;
  int stored_numbers{};           ///< 0: not known
  double effective_parameters{};  ///< NaN: not known
};

struct SegmentView {
  std::string run, name;
  bool hold{};
  double start_s{}, duration_s{}, mean_temperature_c{}, mean_bias_deg_per_h{};
  PerModel<Figures> residual;
};

struct LimitView {
  std::string figure;
  double limit{}, value{};
  bool passed{};
};

struct ThermometerView {
  std::string channel, instrument, calibration;
};

/// "in-sample: the models were fitted to these data" or "not seen by any model", for words beside a figure.
[[nodiscard]] const char* standing(const RunView& run);

struct ReportView {
  std::string rig_name, rig_title, gyro, rig_sha256, program_version, seed;
  std::vector<ThermometerView> thermometers;  ///< none in older reports
  bool simulated{};
  bool quick{};
  std::string verdict;
  std::vector<LimitView> limits;
  double cluster_length_s{};
  CorrelationView correlation;
  RunView rate, random;
  std::string folds;
  bool nested{};
  PerModel<Figures> leave_cycle_out;
  PerModel<std::optional<Figures>> nested_leave_cycle_out;
  PerModel<ModelView> models;
  std::vector<MethodView> methods;
  std::vector<SegmentView> segments;
  std::vector<std::string> warnings;
};

/// Fails with bad_file on syntax (place: file:line:column), another schema, a missing key, a wrong type or lengths that
/// do not fit (place: the key's path).
[[nodiscard]] Result<ReportView> read_report(std::string_view json, const std::string& file);

}  // namespace gyrotherm
