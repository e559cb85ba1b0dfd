// SPDX-License-Identifier: Apache-2.0
#include "report/report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/json.hpp"
#include "core/text.hpp"

namespace gyrotherm::report {

void describe(auto& form, Like<ReportedThermometer> auto& thermometer) {
  form("channel", thermometer.channel);
  form("instrument", thermometer.instrument);
  form("calibration", thermometer.calibration);
}

void describe(auto& form, Like<ReportedRig> auto& rig) {
  form("name", rig.name);
  form("title", rig.title);
  form("gyro", rig.gyro);
  form("gyro_model", rig.gyro_model);
  form("gyro_film", rig.gyro_film);
  form("virtual", rig.is_virtual);
  form("thermometers", rig.thermometers);
}

void describe(auto& form, Like<AcceptedLimit> auto& limit) {
  form("figure", limit.figure);
  form("limit", limit.limit);
  form("value", limit.value);
  form("passed", limit.passed);
}

void describe(auto& form, Like<ReportedCorrelation> auto& correlation) {
  form("correlation_names", correlation.names);
  form("correlation", correlation.magnitude);
  form("correlation_signed", correlation.gradient);
  form("correlation_temperature", correlation.temperature);
  form("correlation_rate", correlation.rate);
  const std::size_t size = correlation.names.size();
  const bool square = correlation.magnitude.size() == size &&
                      std::ranges::all_of(correlation.magnitude, [&](const auto& row) { return row.size() == size; });
  form.expect("correlation", square, "wrong length, expected one row and one column per thermometer");
  for (const auto& [key, values] :
       {std::pair{"correlation_temperature", &correlation.temperature}, {"correlation_rate", &correlation.rate}})
    form.expect(key, values->size() == size, "wrong length, expected one value per thermometer");
  form("selected_pairs", correlation.selected_pairs);
  form.object("selection", [&](auto& selection) {
    selection("threshold", correlation.threshold);
    selection("rank", correlation.rank);
    selection("fallback", correlation.fallback);
    selection("statement", correlation.statement);
  });
}

void describe(auto& form, Like<ReportedResidual> auto& residual) {
  describe(form, residual.all);
  form("ramps", residual.ramps);
  form("holds", residual.holds);
  form("corners", residual.corners);
  form("to_truth", residual.to_truth);
  form.derived("outside_trained_range", residual.outside.clusters);
  form("outside", residual.outside);
  form("effective_parameters", residual.effective_parameters);
  form("expected_in_sample_std_deg_per_h", residual.expected_in_sample_std);
  form.if_present("streamed", residual.streamed.has_value(), residual.streamed);
}

void describe(auto& form, Like<ReportedCycle> auto& cycle) {
  form("name", cycle.name);
  form("start_s", cycle.start_s);
  form("end_s", cycle.end_s);
}

void describe(auto& form, Like<ReportedSeries> auto& series) {
  const auto column = [&](const char* key, auto& values) {
    form(key, values);
    form.expect(key, values.size() == series.time_s.size(), "wrong length, expected one value per point");
  };
  form("time_s", series.time_s);
  column("set_point_c", series.set_point_c);
  form("thermometers", named_values(series.thermometers_c));
  const auto fits = [&](const auto& named) { return named.second.size() == series.time_s.size(); };
  form.expect("thermometers", !series.thermometers_c.empty(), "empty, expected at least one thermometer");
  form.expect("thermometers", std::ranges::all_of(series.thermometers_c, fits),
              "wrong length, expected one value per point");
  column("raw", series.raw);
  for_each_model(series.residual, column);
  form("cycles", series.cycles);
}

void describe(auto& form, Like<ReportedNoise> auto& noise) {
  describe(form, noise.holds);
  form("compensated_holds", noise.compensated_holds);
  form.object("whole_run", [&](auto& whole_run) {
    whole_run("raw", noise.raw);
    describe(whole_run, noise.compensated);
  });
}

void describe(auto& form, Like<ReportedGain> auto& gain) {
  form("from_original", gain.from_original);
  form("paper_ratio", gain.paper_ratio);
  form("residual_reduction", gain.residual_reduction);
}

void describe(auto& form, Like<ReportedRun> auto& run) {
  form("in_sample", run.in_sample);
  form("profile", run.profile);
  form("run_id", run.run_id);
  form("bias_zero", run.bias_zero);
  form("noise_floor_deg_per_h", run.floor.deg_per_h);
  form("noise_floor_error_deg_per_h", run.floor.error_deg_per_h);
  form("noise_floor_differences", run.floor.differences);
  form("noise_floor_statement", run.floor.statement);
  form("allan", run.noise);
  form("characterisation", run.characterisation);
  form("gaps_s", run.gaps_s);
  form("raw", run.raw);
  describe(form, run.residual);
}

void describe(auto& form, Like<ReportedTraining> auto& training) {
  form("run_id", training.run_id);
  form("profile", training.profile);
  form("simulated", training.simulated);
  form("clusters", training.clusters);
  form.if_present("block", training.block.has_value(), training.block);
}

void describe(auto& form, Like<ReportedModel> auto& model) {
  form("inputs", model.inputs);
  form("method", model.method);
  form("terms", model.terms);
  form("rank", model.rank);
  form("stored_numbers", model.stored_numbers);
  form("effective_parameters", model.effective_parameters);
  form("residual_std_deg_per_h", model.residual_std_deg_per_h);
  form("trained_on", model.trained_on);
  form("uncertainty", model.uncertainty);
}

/// Describes the tuning of a model, which the file stores separately from the model.
void describe_tuning(auto& form, Like<ReportedModel> auto& model) {
  auto& swarm = model.options.swarm;
  form("seed", swarm.seed);
  form.object("swarm", [&](auto& form_of_swarm) {
    form_of_swarm("particles", swarm.particles);
    form_of_swarm("iterations", swarm.iterations);
    form_of_swarm("omega_max", swarm.omega_max);
    form_of_swarm("omega_min", swarm.omega_min);
    form_of_swarm("c1", swarm.c1);
    form_of_swarm("c2", swarm.c2);
    form_of_swarm("v_max", swarm.v_max);
    form_of_swarm("end", one_of(model.tuning.swarm.end, svm::kSwarmEnds));
    form_of_swarm("evaluations", model.tuning.swarm.evaluations);
  });
  form.object("bounds", [&](auto& bounds) { describe_bounds(bounds, model.options); });
  form.derived("fitness", "mean squared error on held-out folds, (deg/h)^2");
  form("folds", model.folds);
  form("history", model.tuning.swarm.history);
  form("C", model.parameters.C);
  form("sigma", model.parameters.sigma);
  form("epsilon", model.parameters.epsilon);
  form("epsilon_deg_per_h", model.epsilon_deg_per_h);
  form("support_vectors", model.support_vectors);
  form("certified_gap", model.certified_gap);
  form("kkt_violation", model.kkt_violation);
  form("warnings", model.tuning.warnings);
}

void describe(auto& form, Like<ReportedUncertainty> auto& uncertainty) {
  form("u_deg_per_h", uncertainty.standard_deg_per_h);
  form("k", uncertainty.coverage_factor);
  form("U_deg_per_h", uncertainty.expanded_deg_per_h);
  form("sensitivity_deg_per_h_per_k", uncertainty.sensitivity_deg_per_h_per_k);
}

void describe(auto& form, Like<ReportedVerification> auto& verification) {
  describe(form, verification.figures);
  form("to_truth", verification.to_truth);
  form("coverage", verification.coverage);
}

void describe(auto& form, Like<ReportedLaterRun> auto& run) {
  form("name", run.name);
  form("profile", run.profile);
  form("run_id", run.run_id);
  form("record_sha256", run.record_sha256);
  form("noise_floor_deg_per_h", run.floor.deg_per_h);
  form("noise_floor_error_deg_per_h", run.floor.error_deg_per_h);
  form("raw", run.raw);
}

void describe(auto& form, Like<ReportedMethod> auto& method) {
  form("name", method.name);
  form("inputs", method.inputs);
  form("method", method.method);
  form("title", method.title);
  form("citation", method.citation);
  form("in_sample", method.in_sample);
  form("leave_cycle_out", method.leave_cycle_out);
  form("nested_leave_cycle_out", method.nested);
  form("random", method.random);
  form("later", method.later);
  form("between_runs", method.between_runs);
  form("uncertainty", method.uncertainty);
  form("stored_numbers", method.stored_numbers);
  form("effective_parameters", method.effective_parameters);
}

void describe(auto& form, Like<ReportedSegment> auto& segment) {
  form("run", segment.run);
  form("segment", segment.segment);
  form("name", segment.name);
  form("hold", segment.hold);
  form("start_s", segment.start_s);
  form("duration_s", segment.duration_s);
  form("mean_temperature_c", segment.mean_temperature_c);
  form("mean_bias_deg_per_h", segment.mean_bias_deg_per_h);
  describe(form, segment.residual);
}

/// Describes a part of both runs, one after the other.
void describe_both(auto& form, const char* key, auto& report, auto describe_one) {
  form.object(key, [&](auto& both) {
    both.object("rate", [&](auto& form_of_one) { describe_one(form_of_one, report.rate); });
    both.object("random", [&](auto& form_of_one) { describe_one(form_of_one, report.random); });
  });
}

void describe_clusters(auto& form, Like<Report> auto& report) {
  form("rate", report.rate.clusters);
  form("random", report.random.clusters);
  form("length_s", report.cluster_length_s);
  for (const auto& [key, dropped] :
       {std::pair{"dropped_rest", &ReportedRun::dropped_rest}, {"dropped_gaps", &ReportedRun::dropped_gaps}})
    form.object(key, [&, member = dropped](auto& of_run) {
      of_run("rate", report.rate.*member);
      of_run("random", report.random.*member);
    });
}

void describe_provenance(auto& form, Like<Report> auto& report) {
  form("program_version", report.program_version);
  form("seed", report.seed);
  form("days_later", report.days_later);
  form("rig_sha256", report.rig.sha256);
  form("gyro_model_sha256", report.rig.gyro_model_sha256);
  const auto of_run = [&](const char* key, auto& run) {
    form.object(key, [&](auto& form_of_run) {
      form_of_run.derived("run_id", run.run_id);
      form_of_run.derived("profile", run.profile);
      form_of_run("record_sha256", run.record_sha256);
      form_of_run.if_present("record_file_sha256", !run.record_file_sha256.empty(), run.record_file_sha256);
      form_of_run("profile_sha256", run.profile_sha256);
    });
  };
  of_run("rate", report.rate);
  of_run("random", report.random);
}

void describe(auto& form, Like<Report> auto& report) {
  form.derived("schema", kReportSchema);
  form("rig", report.rig);
  form.if_present("thermal", true, report.thermal);
  form("quick", report.quick);
  form.object("accept", [&](auto& accept) {
    accept.derived("verdict", overall_verdict(report));
    accept("limits", report.accept);
  });
  form.object("clusters", [&](auto& clusters) { describe_clusters(clusters, report); });
  describe(form, report.correlation);
  form.derived("noise_floor_deg_per_h", report.random.floor.deg_per_h);
  form("rate", report.rate);
  form("random", report.random);
  const auto leave_cycle_out = [&](const char* key, bool nested, auto& figures) {
    form.object(key, [&](auto& form_of_figures) {
      form_of_figures.derived("nested", nested);
      form_of_figures("folds", report.folds);
      describe(form_of_figures, figures);
    });
  };
  leave_cycle_out("rate_leave_cycle_out", false, report.leave_cycle_out);
  leave_cycle_out("rate_nested_leave_cycle_out", true, report.nested_leave_cycle_out);
  describe_both(form, "improvement", report, [](auto& improvement, auto& run) {
    auto& gain = run.gain;
    improvement.object("three_point", [&](auto& three) { three("from_original", gain.three_point.from_original); });
    improvement("multi_point", gain.multi_point);
    improvement("multi_point_t", gain.multi_point_t);
  });
  form("models", report.models);
  form.object("tuning", [&](auto& tuning) {
    for_each_model(report.models, [&](const char* key, auto& model) {
      tuning.object(key, [&](auto& form_of_one) { describe_tuning(form_of_one, model); });
    });
  });
  form("later", report.later);
  form("methods", report.methods);
  form("recommendation", report.recommendation);
  form("warnings", report.warnings);
  form.object("provenance", [&](auto& provenance) { describe_provenance(provenance, report); });
  form("segments", report.segments);
  form.object("series", [&](auto& series) {
    series("rate", report.rate.series);
    series("random", report.random.series);
  });
}

namespace {

/// Returns the names of all values to which a limit can apply.
std::vector<std::string> figures_with_limits() {
  std::vector<std::string> all{"noise_floor_deg_per_h", "rate.noise_floor_deg_per_h", "random.noise_floor_deg_per_h"};
  for (const std::string_view run : {"rate", "random", "rate_leave_cycle_out"})
    for (const std::string_view model : {"raw", "three_point", "multi_point", "multi_point_t"})
      for (const std::string_view figure : {"std", "mean", "rmse", "max_abs"})
        if (run != "rate_leave_cycle_out" || model != "raw")
          all.push_back(fmt::format("{}.{}.{}_deg_per_h", run, model, figure));
  return all;
}

}  // namespace

std::string overall_verdict(const Report& report) {
  if (report.accept.empty()) return "no limit";
  return std::ranges::all_of(report.accept, &AcceptedLimit::passed) ? "PASS" : "FAIL";
}

const char* in_sample_text(const ReportedRun& run) {
  return run.in_sample ? "in-sample: the models were fitted to these data" : "not used to train any model";
}

std::string to_json(const Report& report) {
  const Json json = make_json(report);
  std::string text;
  for (const auto& [key, value] : json.items())
    text += fmt::format("{}\n\"{}\": {}", text.empty() ? "{" : ",", key, json_text(value));
  return text + "\n}\n";
}

Result<Report> read_report(std::string_view json, const std::string& file) {
  const Result<JsonNode> parsed = JsonNode::parse(json, file);
  if (!parsed) return failure(parsed.error());
  const JsonNode& root = *parsed;
  const std::string schema = root["schema"].text();
  if (schema != kReportSchema) root["schema"].note_error(fmt::format("\"{}\", expected \"{}\"", schema, kReportSchema));
  if (const auto verdict = root.verdict(); !verdict) return failure(verdict.error());
  Report report;
  report.thermal = not_available("an earlier version of gyrotherm wrote this report");
  read_json(root, report);
  if (const auto verdict = root.verdict(); !verdict) return failure(verdict.error());
  return report;
}

Result<ReportedThermalModel> read_thermal_figure(std::string_view json, const std::string& from) {
  const Result<JsonNode> parsed = JsonNode::parse(json, from);
  if (!parsed) return failure(parsed.error());
  const JsonNode& root = *parsed;
  if (const std::string schema = root["schema"].text(); schema != kThermalFigureSchema)
    root["schema"].note_error(fmt::format("\"{}\", expected \"{}\"", schema, kThermalFigureSchema));
  ReportedThermalModel model;
  read_json(root, model);
  if (const auto verdict = root.verdict(); !verdict) return failure(verdict.error());
  return model;
}

Result<void> check_limit(const std::string& figure) {
  const auto known = figures_with_limits();
  if (std::ranges::find(known, figure) != known.end()) return {};
  const auto near = find_nearest(figure, known);
  return failure(
      FaultKind::usage, figure,
      "not a value of the report" + (near.empty() ? std::string() : fmt::format("; did you mean \"{}\"?", near)));
}

std::vector<AcceptedLimit> compare_with_limits(const Report& report, const std::vector<Limit>& limits) {
  const Json json = make_json(report);
  std::vector<AcceptedLimit> all;
  for (const auto& [figure, at_most] : limits) {
    std::string path = "/" + figure;
    std::ranges::replace(path, '.', '/');
    const double value = json.at(Json::json_pointer(path)).get<double>();
    all.push_back({.figure = figure, .limit = at_most, .value = value, .passed = value <= at_most});
  }
  return all;
}

}  // namespace gyrotherm::report
