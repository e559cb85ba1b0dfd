#include "report/report_json.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <variant>

namespace gyrotherm {
namespace {

using Json = nlohmann::ordered_json;

/// A Verification or a Model of each kind, by the key of the report.
template <class Run>
auto by_key(const Run& run) {
  return std::array{std::pair{"three_point", &run.three_point}, std::pair{"multi_point", &run.multi_point},
                    std::pair{"multi_point_t", &run.multi_point_t}};
}

template <class Vector>
Json list(const Vector& values) {
  Json array = Json::array();
  for (Eigen::Index k = 0; k < values.size(); ++k) array.push_back(values(k));
  return array;
}

Json rows(const Eigen::MatrixXd& matrix) {
  Json array = Json::array();
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) array.push_back(list(matrix.row(k)));
  return array;
}

Json terms(const std::vector<Term>& all) {
  Json array = Json::array();
  for (const Term& term : all) array.push_back(text(term));
  return array;
}

Json figures(const Figures& f) {
  return {{"std_deg_per_h", f.std},
          {"mean_deg_per_h", f.mean},
          {"rmse_deg_per_h", f.rmse},
          {"max_abs_deg_per_h", f.max_abs},
          {"count", f.count}};
}

Json verified(const Verification& verification) {
  Json json = figures(verification.compensated);
  json["ramps"] = figures(verification.ramps);
  json["holds"] = figures(verification.holds);
  json["corners"] = figures(verification.corners);
  json["outside_trained_range"] = verification.outside_trained_range;
  return json;
}

Json gaps(const Dataset& dataset) {
  Json array = Json::array();
  for (const auto& [from, to] : dataset.gaps_s) array.push_back({from, to});
  return array;
}

Json run_section(const ReportedRun& run) {
  Json json;
  json["in_sample"] = std::ranges::any_of(by_key(run), [](const auto& entry) { return entry.second->trained_on_this; });
  json["profile"] = run.dataset.profile_name;
  json["run_id"] = run.dataset.run_id;
  json["bias_zero"] = run.dataset.bias_zero;
  json["noise_floor_deg_per_h"] = run.multi_point.floor.deg_per_h;
  json["noise_floor_differences"] = run.multi_point.floor.differences;
  json["gaps_s"] = gaps(run.dataset);
  json["raw"] = figures(run.multi_point.raw);
  for (const auto& [key, verification] : by_key(run)) json[key] = verified(*verification);
  return json;
}

Json clusters_section(const ReportedRun& rate, const ReportedRun& random) {
  return {{"rate", rate.clusters.start_s.size()},
          {"random", random.clusters.start_s.size()},
          {"length_s", rate.clusters.length_s},
          {"dropped_rest", {{"rate", rate.clusters.dropped_rest}, {"random", random.clusters.dropped_rest}}},
          {"dropped_gaps", {{"rate", rate.clusters.dropped_gaps}, {"random", random.clusters.dropped_gaps}}}};
}

Json leave_cycle_out(const ReportedModels& models) {
  Json json = {{"nested", false}, {"folds", models.multi_point.folds}};
  for (const auto& [key, model] : by_key(models)) json[key] = figures(model->leave_cycle_out);
  return json;
}

Json improvement_section(const ReportedRun& run) {
  const double raw = run.multi_point.raw.std, three = run.three_point.compensated.std;
  const auto against_three = [&](double multi) {
    const Improvement gain = improvement(raw, three, multi);
    return Json{{"from_original", gain.multi_point_from_original},
                {"paper_ratio", gain.paper_ratio},
                {"residual_reduction", gain.residual_reduction}};
  };
  return {{"three_point", {{"from_original", improvement(raw, three, three).three_point_from_original}}},
          {"multi_point", against_three(run.multi_point.compensated.std)},
          {"multi_point_t", against_three(run.multi_point_t.compensated.std)}};
}

Json swarm_section(const SwarmOptions& options, const SwarmSummary& summary) {
  return {{"particles", options.particles},
          {"iterations", options.iterations},
          {"omega_max", options.omega_max},
          {"omega_min", options.omega_min},
          {"c1", options.c1},
          {"c2", options.c2},
          {"v_max", options.v_max},
          {"end", name(summary.end)},
          {"evaluations", summary.evaluations}};
}

Json tuning_section(const Model& model) {
  const auto& svr = std::get<SvrModel>(model.function);
  const TuningOptions& options = model.tuning_options;
  Json json = {{"seed", options.swarm.seed}, {"swarm", swarm_section(options.swarm, model.tuning.swarm)}};
  json["bounds"] = {{"log2_c", {options.log2_c_min, options.log2_c_max}},
                    {"log2_sigma", {options.log2_sigma_min, options.log2_sigma_max}},
                    {"log2_epsilon", {options.log2_epsilon_min, options.log2_epsilon_max}},
                    {"fixed_epsilon", options.fixed_epsilon}};
  json["fitness"] = "mean squared error on held-out folds, (deg/h)^2";
  json["folds"] = model.folds;
  json["history"] = model.tuning.swarm.history;
  json["C"] = svr.parameters.C;
  json["sigma"] = svr.parameters.sigma;
  json["epsilon"] = svr.parameters.epsilon;
  json["epsilon_deg_per_h"] = svr.parameters.epsilon * model.target_std_deg_per_h;
  json["support_vectors"] = svr.support_vectors.rows();
  json["certified_gap"] = svr.relative_gap;
  json["kkt_violation"] = svr.kkt_violation;
  json["warnings"] = model.tuning.warnings;
  return json;
}

Json model_section(const Model& model) {
  Json json = {{"inputs", model.inputs},
               {"method", model.method},
               {"terms", terms(model.terms)},
               {"rank", rank_of(model.terms)}};
  json["trained_on"] = Json::array();
  for (const TrainingRecord& record : model.trained_on) {
    json["trained_on"].push_back({{"run_id", record.run_id},
                                  {"profile", record.profile_name},
                                  {"simulated", record.simulated},
                                  {"clusters", record.clusters}});
  }
  return json;
}

Json thermometers(const Clusters& clusters) {
  Json json = Json::object();
  for (std::size_t k = 0; k < clusters.thermometers.size(); ++k) {
    json[clusters.thermometers[k]] = list(clusters.temperature_c.col(static_cast<Eigen::Index>(k)));
  }
  return json;
}

/// Neighbouring clusters of one cycle, in seconds since the start.
Json cycles(const ReportedRun& run) {
  const Clusters& clusters = run.clusters;
  Json array = Json::array();
  int current = -1;
  for (Eigen::Index k = 0; k < clusters.cycle.size(); ++k) {
    const int cycle = clusters.cycle(k);
    const bool known = cycle >= 0 && cycle < static_cast<int>(run.dataset.cycles.size());
    if (known && cycle != current) {
      array.push_back(
          {{"name", run.dataset.cycles[static_cast<std::size_t>(cycle)]}, {"start_s", clusters.start_s(k)}});
    }
    if (known) array.back()["end_s"] = clusters.start_s(k) + clusters.length_s;
    current = known ? cycle : -1;
  }
  return array;
}

Json series_section(const ReportedRun& run) {
  Json json = {{"time_s", list(run.clusters.start_s)}, {"set_point_c", list(run.clusters.set_point_c)}};
  json["thermometers"] = thermometers(run.clusters);
  json["raw"] = list(run.clusters.bias_deg_per_h);
  for (const auto& [key, verification] : by_key(run)) json[key] = list(verification->residual_deg_per_h);
  json["cycles"] = cycles(run);
  return json;
}

void add_segments(Json& array, const char* run_key, const ReportedRun& run) {
  for (std::size_t k = 0; k < run.multi_point.segments.size(); ++k) {
    const SegmentFigures& segment = run.multi_point.segments[k];
    Json json = {{"run", run_key},
                 {"segment", segment.segment},
                 {"name", segment.name},
                 {"hold", segment.hold},
                 {"start_s", segment.start_s},
                 {"duration_s", segment.duration_s},
                 {"mean_temperature_c", segment.mean_temperature_c},
                 {"mean_bias_deg_per_h", segment.mean_bias_deg_per_h}};
    for (const auto& [key, verification] : by_key(run)) json[key] = figures(verification->segments[k].residual);
    array.push_back(std::move(json));
  }
}

Json provenance(const ReportInput& input) {
  const auto of_run = [](const ReportedRun& run) {
    return Json{{"run_id", run.dataset.run_id},
                {"profile", run.dataset.profile_name},
                {"record_sha256", run.record_sha256},
                {"profile_sha256", run.profile_sha256}};
  };
  return {{"program_version", input.program_version},
          {"seed", input.seed},
          {"rig_sha256", input.rig.sha256},
          {"rate", of_run(input.rate)},
          {"random", of_run(input.random)}};
}

Json method_row(const ComparedMethod& row) {
  return {{"name", row.name},
          {"inputs", row.inputs},
          {"method", row.method},
          {"in_sample", figures(row.in_sample)},
          {"leave_cycle_out", figures(row.leave_cycle_out)},
          {"random", figures(row.random)}};
}

Json methods(const ReportInput& input) {
  Json array = Json::array();
  const auto models = by_key(input.models);
  const auto on_rate = by_key(input.rate), on_random = by_key(input.random);
  for (std::size_t k = 0; k < models.size(); ++k) {
    const auto& [key, model] = models[k];
    array.push_back(method_row({key, model->inputs, model->method, on_rate[k].second->compensated,
                                model->leave_cycle_out, on_random[k].second->compensated}));
  }
  for (const ComparedMethod& row : input.compared) array.push_back(method_row(row));
  return array;
}

/// Each once, in the order of first mention.
class Warnings {
 public:
  void add(const std::string& about, const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      const std::string whole = about.empty() ? text : about + ": " + text;
      if (seen_.insert(whole).second) all_.push_back(whole);
    }
  }
  [[nodiscard]] Json json() const { return all_; }

 private:
  std::set<std::string> seen_;
  std::vector<std::string> all_;
};

Json warnings(const ReportInput& input) {
  Warnings all;
  all.add("", input.warnings);
  if (input.rate.dataset.three_point_stand_in) {
    all.add("", {"three-point: the record names no shell thermometer; a stand-in is used"});
  }
  for (const auto& [key, model] : by_key(input.models)) all.add(model->inputs, model->warnings);
  const auto add_run = [&](const std::string& run_name, const ReportedRun& run) {
    const auto models = by_key(input.models);
    const auto verifications = by_key(run);
    for (std::size_t k = 0; k < models.size(); ++k) {
      all.add(models[k].second->inputs + " on the " + run_name + " run", verifications[k].second->warnings);
    }
  };
  add_run("rate", input.rate);
  add_run("random", input.random);
  return all.json();
}

Json accept_section(const std::vector<AcceptedLimit>& limits) {
  const bool passed = std::ranges::all_of(limits, &AcceptedLimit::passed);
  Json json = {{"verdict", limits.empty() ? "no limit" : passed ? "PASS" : "FAIL"}, {"limits", Json::array()}};
  for (const AcceptedLimit& limit : limits) {
    json["limits"].push_back(
        {{"figure", limit.figure}, {"limit", limit.limit}, {"value", limit.value}, {"passed", limit.passed}});
  }
  return json;
}

void add_correlation(Json& json, const ReportInput& input) {
  const Correlation& correlation = input.correlation;
  const Selection& selection = input.models.multi_point.selection;
  json["correlation_names"] = correlation.names;
  json["correlation"] = rows(correlation.gradient.cwiseAbs());
  json["correlation_signed"] = rows(correlation.gradient);
  json["correlation_temperature"] = list(correlation.temperature);
  json["correlation_rate"] = list(correlation.rate);
  json["selected_pairs"] = terms(selection.terms);
  json["selection"] = {{"threshold", selection.threshold},
                       {"rank", selection.rank},
                       {"fallback", selection.fallback},
                       {"statement", selection.statement}};
}

void check(const ReportedRun& run) {
  for ([[maybe_unused]] const auto& [key, verification] : by_key(run)) {
    assert(verification->residual_deg_per_h.size() == run.clusters.bias_deg_per_h.size());
    assert(verification->segments.size() == run.multi_point.segments.size());
  }
}

/// One line per key of the first level, so that two reports can be compared line by line.
std::string lines(const Json& json) {
  std::string out = "{";
  for (const auto& [key, value] : json.items()) {
    out += (out.size() > 1 ? ",\n" : "\n") + Json(key).dump() + ": " +
           value.dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  return out + "\n}\n";
}

}  // namespace

std::string report_json(const ReportInput& input) {
  check(input.rate);
  check(input.random);
  const bool simulated = input.rate.dataset.simulated || input.random.dataset.simulated;
  Json json = {{"schema", kReportSchema}};
  json["rig"] = {{"name", input.rig.name},
                 {"title", input.rig.title},
                 {"gyro", input.rig.gyro},
                 {"virtual", input.rig.is_virtual || simulated}};
  json["quick"] = input.models.multi_point.quick;
  json["accept"] = accept_section(input.accept);
  json["clusters"] = clusters_section(input.rate, input.random);
  add_correlation(json, input);
  json["noise_floor_deg_per_h"] = input.random.multi_point.floor.deg_per_h;
  json["rate"] = run_section(input.rate);
  json["random"] = run_section(input.random);
  json["rate_leave_cycle_out"] = leave_cycle_out(input.models);
  json["improvement"] = {{"rate", improvement_section(input.rate)}, {"random", improvement_section(input.random)}};
  for (const auto& [key, model] : by_key(input.models)) {
    json["models"][key] = model_section(*model);
    json["tuning"][key] = tuning_section(*model);
  }
  json["methods"] = methods(input);
  json["warnings"] = warnings(input);
  json["provenance"] = provenance(input);
  json["segments"] = Json::array();
  add_segments(json["segments"], "rate", input.rate);
  add_segments(json["segments"], "random", input.random);
  json["series"] = {{"rate", series_section(input.rate)}, {"random", series_section(input.random)}};
  return lines(json);
}

}  // namespace gyrotherm
