#include "report/report_view.hpp"

#include <fmt/format.h>

#include <limits>

#include "core/json_reader.hpp"
#include "report/report_json.hpp"

namespace gyrotherm {
namespace {

/// null as 0.
double known_or_0(const JsonPlace& json) { return json.is_null() ? 0 : json.number(); }

Figures read_figures(const JsonPlace& json) {
  return {json["std_deg_per_h"].number(),
          json["mean_deg_per_h"].number(),
          json["rmse_deg_per_h"].number(),
          json["max_abs_deg_per_h"].number(),
          json["count"].integer(),
          {known_or_0(json["effective_count"]), known_or_0(json["effective_count_of_mean"])}};
}

std::optional<Figures> read_optional_figures(const JsonPlace& json) {
  if (json.is_null()) return std::nullopt;
  return read_figures(json);
}

/// The same read for each of the three models.
template <class Read>
auto per_model(const JsonPlace& json, Read read) {
  return PerModel<decltype(read(json))>{read(json["three_point"]), read(json["multi_point"]),
                                        read(json["multi_point_t"])};
}

ResidualView read_residual(const JsonPlace& json) {
  const JsonPlace outside = json["outside"];
  return {.all = read_figures(json),
          .ramps = read_figures(json["ramps"]),
          .holds = read_figures(json["holds"]),
          .corners = read_figures(json["corners"]),
          .effective_parameters = json["effective_parameters"].number(),
          .expected_in_sample_std = json["expected_in_sample_std_deg_per_h"].number(),
          .outside_policy = outside["policy"].text(),
          .outside_farthest_term = outside["farthest_term"].text(),
          .outside = outside["clusters"].integer(),
          .outside_farthest = outside["farthest"].number()};
}

PerModel<GainView> read_gain(const JsonPlace& json) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto against_three = [](const JsonPlace& at) {
    return GainView{at["from_original"].number(), at["paper_ratio"].number(), at["residual_reduction"].number()};
  };
  return {{json["three_point"]["from_original"].number(), kNone, kNone},
          against_three(json["multi_point"]),
          against_three(json["multi_point_t"])};
}

std::vector<double> hours(std::vector<double> seconds) {
  for (double& value : seconds) value /= 3600;
  return seconds;
}

/// A column as long as those beside it.
std::vector<double> read_column(const JsonPlace& json, std::size_t length) {
  std::vector<double> values = json.numbers();
  if (values.size() != length)
    json.mistake(fmt::format("{} values, expected {}, one of each point", values.size(), length));
  return values;
}

SeriesView read_series(const JsonPlace& json) {
  SeriesView series;
  series.time_h = hours(json["time_s"].numbers());
  const auto length = series.time_h.size();
  series.set_point_c = read_column(json["set_point_c"], length);
  series.raw = read_column(json["raw"], length);
  for (const auto& [name, column] : json["thermometers"].members()) {
    series.thermometers_c.emplace_back(name, read_column(column, length));
  }
  if (series.thermometers_c.empty()) json["thermometers"].mistake("empty, expected at least one thermometer");
  series.compensated = per_model(json, [&](const JsonPlace& column) { return read_column(column, length); });
  for (const JsonPlace& cycle : json["cycles"].elements()) {
    series.cycles.push_back({cycle["name"].text(), cycle["start_s"].number() / 3600, cycle["end_s"].number() / 3600});
  }
  return series;
}

AllanCurveView read_allan_curve(const JsonPlace& json) {
  AllanCurveView curve;
  for (const JsonPlace& point : json.elements()) {
    curve.push_back(
        {point["tau_s"].number(), point["deviation_deg_per_h"].number(), point["error_deg_per_h"].number()});
  }
  return curve;
}

HoldNoiseView read_hold_noise(const JsonPlace& json) {
  HoldNoiseView view;
  view.statement = json["statement"].text();
  view.curve = read_allan_curve(json["curve"]);
  view.fitted_deg_per_h = read_column(json["fitted_deg_per_h"], view.curve.size());
  for (const auto& [symbol, noise] : json["coefficients"].members()) {
    view.coefficients.push_back({symbol, noise["name"].text(), noise["unit"].text(), noise["formula"].text(),
                                 noise["read_off_s"].number(), noise["seen"].boolean(), noise["value"].number(),
                                 noise["error"].number(), noise["at_most"].number()});
  }
  view.lowest_tau_s = json["lowest_tau_s"].number();
  view.misfit = json["misfit"].number();
  return view;
}

AllanView read_allan(const JsonPlace& json) {
  return {.holds = read_hold_noise(json),
          .compensated_holds = read_hold_noise(json["compensated_holds"]),
          .raw = read_allan_curve(json["whole_run"]["raw"]),
          .compensated = per_model(json["whole_run"], read_allan_curve)};
}

RunView read_run(const JsonPlace& root, std::string_view key) {
  const JsonPlace json = root[key], clusters = root["clusters"], provenance = root["provenance"][key];
  RunView run;
  run.in_sample = json["in_sample"].boolean();
  run.profile = json["profile"].text();
  run.run_id = json["run_id"].text();
  run.bias_zero = json["bias_zero"].text();
  run.record_sha256 = provenance["record_sha256"].text();
  run.profile_sha256 = provenance["profile_sha256"].text();
  run.noise_floor_deg_per_h = json["noise_floor_deg_per_h"].number();
  run.noise_floor_error_deg_per_h = json["noise_floor_error_deg_per_h"].number();
  run.noise_floor_differences = json["noise_floor_differences"].integer();
  run.clusters = clusters[key].integer();
  run.dropped_rest = clusters["dropped_rest"][key].integer();
  run.dropped_gaps = clusters["dropped_gaps"][key].integer();
  run.gaps = static_cast<int>(json["gaps_s"].elements().size());
  run.raw = read_figures(json["raw"]);
  run.residual = per_model(json, read_residual);
  run.gain = read_gain(root["improvement"][key]);
  run.series = read_series(root["series"][key]);
  run.allan = read_allan(json["allan"]);
  return run;
}

std::pair<double, double> read_bounds(const JsonPlace& json) {
  const std::vector<double> ends = json.numbers();
  if (ends.size() == 2) return {ends[0], ends[1]};
  json.mistake("wrong length, expected a lower and an upper bound");
  return {};
}

void read_tuning(ModelView& model, const JsonPlace& json) {
  model.C = json["C"].number();
  model.sigma = json["sigma"].number();
  model.epsilon = json["epsilon"].number();
  model.epsilon_deg_per_h = json["epsilon_deg_per_h"].number();
  model.support_vectors = json["support_vectors"].integer();
  model.certified_gap = json["certified_gap"].number();
  model.kkt_violation = json["kkt_violation"].number();
  model.history = json["history"].numbers();
  model.seed = json["seed"].digits();
  model.particles = json["swarm"]["particles"].integer();
  model.iterations = json["swarm"]["iterations"].integer();
  model.evaluations = json["swarm"]["evaluations"].integer();
  model.swarm_end = json["swarm"]["end"].text();
  model.log2_c = read_bounds(json["bounds"]["log2_c"]);
  model.log2_sigma = read_bounds(json["bounds"]["log2_sigma"]);
  model.log2_epsilon = read_bounds(json["bounds"]["log2_epsilon"]);
  model.fixed_epsilon = json["bounds"]["fixed_epsilon"].number();
}

ModelView read_model(const JsonPlace& json, const JsonPlace& tuning) {
  ModelView model;
  model.inputs = json["inputs"].text();
  model.method = json["method"].text();
  model.terms = json["terms"].texts();
  model.rank = json["rank"].integer();
  model.stored_numbers = json["stored_numbers"].integer();
  model.effective_parameters = json["effective_parameters"].number();
  for (const JsonPlace& record : json["trained_on"].elements()) {
    model.trained_clusters += record["clusters"].integer();
    if (!model.trained_on.empty()) model.trained_on += ", ";
    model.trained_on += record["profile"].text() + " (run " + record["run_id"].text().substr(0, 8) + ")";
  }
  read_tuning(model, tuning);
  return model;
}

CorrelationView read_correlation(const JsonPlace& root) {
  CorrelationView view;
  view.names = root["correlation_names"].texts();
  const JsonPlace array = root["correlation"];
  for (const JsonPlace& row : array.elements()) {
    view.magnitude.push_back(row.numbers());
    if (view.magnitude.back().size() != view.names.size())
      row.mistake("wrong length, expected one value per thermometer");
  }
  if (view.magnitude.size() != view.names.size()) array.mistake("wrong length, expected one row per thermometer");
  view.temperature = root["correlation_temperature"].numbers();
  view.rate = root["correlation_rate"].numbers();
  if (view.temperature.size() != view.names.size())
    root["correlation_temperature"].mistake("wrong length, expected one value per thermometer");
  if (view.rate.size() != view.names.size())
    root["correlation_rate"].mistake("wrong length, expected one value per thermometer");
  view.selected_pairs = root["selected_pairs"].texts();
  const JsonPlace selection = root["selection"];
  view.threshold = selection["threshold"].number();
  view.rank = selection["rank"].integer();
  view.fallback = selection["fallback"].boolean();
  view.statement = selection["statement"].text();
  return view;
}

std::vector<SegmentView> read_segments(const JsonPlace& json) {
  std::vector<SegmentView> all;
  for (const JsonPlace& segment : json.elements()) {
    all.push_back({segment["run"].text(), segment["name"].text(), segment["hold"].boolean(),
                   segment["start_s"].number(), segment["duration_s"].number(), segment["mean_temperature_c"].number(),
                   segment["mean_bias_deg_per_h"].number(), per_model(segment, read_figures)});
  }
  return all;
}

std::vector<MethodView> read_methods(const JsonPlace& json) {
  std::vector<MethodView> all;
  for (const JsonPlace& row : json.elements()) {
    all.push_back({.inputs = row["inputs"].text(),
                   .method = row["method"].text(),
                   .title = row["title"].text(),
                   .citation = row["citation"].text(),
                   .in_sample = read_figures(row["in_sample"]),
                   .leave_cycle_out = read_figures(row["leave_cycle_out"]),
                   .random = read_figures(row["random"]),
                   .nested = read_optional_figures(row["nested_leave_cycle_out"]),
                   .stored_numbers = row["stored_numbers"].integer(),
                   .effective_parameters = row["effective_parameters"].number()});
  }
  return all;
}

std::vector<LimitView> read_limits(const JsonPlace& json) {
  std::vector<LimitView> all;
  for (const JsonPlace& limit : json.elements()) {
    all.push_back(
        {limit["figure"].text(), limit["limit"].number(), limit["value"].number(), limit["passed"].boolean()});
  }
  return all;
}

std::vector<ThermometerView> read_thermometers(const JsonPlace& rig) {
  std::vector<ThermometerView> all;
  for (const auto& [key, list] : rig.members())
    if (key == "thermometers")
      for (const JsonPlace& one : list.elements())
        all.push_back({one["channel"].text(), one["instrument"].text(), one["calibration"].text()});
  return all;
}

void read_head(ReportView& view, const JsonPlace& root) {
  view.rig_name = root["rig"]["name"].text();
  view.rig_title = root["rig"]["title"].text();
  view.gyro = root["rig"]["gyro"].text();
  view.simulated = root["rig"]["virtual"].boolean();
  view.thermometers = read_thermometers(root["rig"]);
  view.rig_sha256 = root["provenance"]["rig_sha256"].text();
  view.program_version = root["provenance"]["program_version"].text();
  view.seed = root["provenance"]["seed"].digits();
  view.quick = root["quick"].boolean();
  view.verdict = root["accept"]["verdict"].text();
  view.limits = read_limits(root["accept"]["limits"]);
  view.cluster_length_s = root["clusters"]["length_s"].number();
  view.folds = root["rate_leave_cycle_out"]["folds"].text();
  view.nested = root["rate_leave_cycle_out"]["nested"].boolean();
  view.warnings = root["warnings"].texts();
}

}  // namespace

const char* standing(const RunView& run) {
  return run.in_sample ? "in-sample: the models were fitted to these data" : "not seen by any model";
}

Result<ReportView> read_report(std::string_view json, const std::string& file) {
  const Result<JsonPlace> parsed = JsonPlace::parse(json, file);
  if (!parsed) return failure(parsed.error());
  const JsonPlace& root = *parsed;
  const std::string schema = root["schema"].text();
  if (schema != kReportSchema) root["schema"].mistake(fmt::format("\"{}\", expected \"{}\"", schema, kReportSchema));
  if (const auto verdict = root.verdict(); !verdict) return failure(verdict.error());
  ReportView view;
  read_head(view, root);
  view.correlation = read_correlation(root);
  view.rate = read_run(root, "rate");
  view.random = read_run(root, "random");
  view.leave_cycle_out = per_model(root["rate_leave_cycle_out"], read_figures);
  view.nested_leave_cycle_out = per_model(root["rate_nested_leave_cycle_out"], read_optional_figures);
  const auto model = [&](const char* key) { return read_model(root["models"][key], root["tuning"][key]); };
  view.models = {model("three_point"), model("multi_point"), model("multi_point_t")};
  view.methods = read_methods(root["methods"]);
  view.segments = read_segments(root["segments"]);
  if (const auto verdict = root.verdict(); !verdict) return failure(verdict.error());
  return view;
}

}  // namespace gyrotherm
