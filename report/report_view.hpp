/// What the views of the report read back from report.json: plain structs, complete or not there at all.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/statistics.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// The residual of one model on one record.
struct ResidualView {
  Figures all, ramps, holds, corners;
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

struct RunView {
  bool in_sample{};
  std::string profile, run_id, bias_zero, record_sha256, profile_sha256;
  double noise_floor_deg_per_h{};
  int noise_floor_differences{};
  int clusters{}, dropped_rest{}, dropped_gaps{}, gaps{};
  Figures raw;
  PerModel<ResidualView> residual;
  PerModel<GainView> gain;
  SeriesView series;
};

struct ModelView {
  std::string inputs, method, trained_on;
  std::vector<std::string> terms;
  int rank{};
  int trained_clusters{};
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
  std::string inputs, method;
  Figures in_sample, leave_cycle_out, random;
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

/// "in-sample: the models were fitted to these data" or "not seen by any model", for words beside a figure.
[[nodiscard]] const char* standing(const RunView& run);

struct ReportView {
  std::string rig_name, rig_title, gyro, rig_sha256, program_version, seed;
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
  PerModel<ModelView> models;
  std::vector<MethodView> methods;
  std::vector<SegmentView> segments;
  std::vector<std::string> warnings;
};

/// Fails with bad_file on syntax (place: file:line:column), another schema, a missing key, a wrong type or lengths that
/// do not fit (place: the key's path).
[[nodiscard]] Result<ReportView> read_report(std::string_view json, const std::string& file);

}  // namespace gyrotherm
