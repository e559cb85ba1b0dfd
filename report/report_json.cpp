#include "report/report_json.hpp"

#include <algorithm>
#include <cassert>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "report/json_pieces.hpp"
#include "report/report_json_parts.hpp"

namespace gyrotherm {
namespace {

using Json = nlohmann::ordered_json;

Json rows(const Eigen::MatrixXd& matrix) {
  Json array = Json::array();
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) array.push_back(json_list<Json>(matrix.row(k)));
  return array;
}

Json terms(const std::vector<Term>& all) {
  Json array = Json::array();
  for (const Term& term : all) array.push_back(text(term));
  return array;
}

Json clusters_section(const ReportedRun& rate, const ReportedRun& random) {
  return {{"rate", rate.clusters.start_s.size()},
          {"random", random.clusters.start_s.size()},
          {"length_s", rate.clusters.length_s},
          {"dropped_rest", {{"rate", rate.clusters.dropped_rest}, {"random", random.clusters.dropped_rest}}},
          {"dropped_gaps", {{"rate", rate.clusters.dropped_gaps}, {"random", random.clusters.dropped_gaps}}}};
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

Json thermometers(const std::vector<ReportedThermometer>& all) {
  Json array = Json::array();
  for (const auto& one : all)
    array.push_back({{"channel", one.channel}, {"instrument", one.instrument}, {"calibration", one.calibration}});
  return array;
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
          {"gyro_model_sha256", input.rig.gyro_model_sha256},
          {"rate", of_run(input.rate)},
          {"random", of_run(input.random)}};
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

/// The keys of the first level and their values, each on a line of its own, so that two reports can be compared line by
/// line.
class Lines {
 public:
  void add(const char* key, const Json& value) { add_text(key, text_of(value)); }
  void add_text(const char* key, const std::string& json) {
    out_ += (out_.size() > 1 ? ",\n\"" : "\n\"") + std::string(key) + "\": " + json;
  }
  [[nodiscard]] std::string finish() && { return std::move(out_) + "\n}\n"; }

 private:
  std::string out_ = "{";
};

void add_correlation(Lines& lines, const ReportInput& input) {
  const Correlation& correlation = input.correlation;
  const Selection& selection = input.models.multi_point.selection;
  lines.add("correlation_names", correlation.names);
  lines.add("correlation", rows(correlation.gradient.cwiseAbs()));
  lines.add("correlation_signed", rows(correlation.gradient));
  lines.add("correlation_temperature", json_list<Json>(correlation.temperature));
  lines.add("correlation_rate", json_list<Json>(correlation.rate));
  lines.add("selected_pairs", terms(selection.terms));
  lines.add("selection", {{"threshold", selection.threshold},
                          {"rank", selection.rank},
                          {"fallback", selection.fallback},
                          {"statement", selection.statement}});
}

void check(const ReportedRun& run) {
  for ([[maybe_unused]] const auto& [key, verification] : by_key(run)) {
    assert(verification->residual_deg_per_h.size() == run.clusters.bias_deg_per_h.size());
    assert(verification->segments.size() == run.multi_point.segments.size());
  }
}

}  // namespace

std::string report_json(const ReportInput& input) {
  check(input.rate);
  check(input.random);
  const bool simulated = input.rate.dataset.simulated || input.random.dataset.simulated;
  Lines lines;
  lines.add("schema", kReportSchema);
  lines.add("rig", {{"name", input.rig.name},
                    {"title", input.rig.title},
                    {"gyro", input.rig.gyro},
                    {"gyro_model", input.rig.gyro_model},
                    {"gyro_film", input.rig.gyro_film},
                    {"virtual", input.rig.is_virtual || simulated},
                    {"thermometers", thermometers(input.rig.thermometers)}});
  lines.add("quick", input.models.multi_point.quick);
  lines.add("accept", accept_section(input.accept));
  lines.add("clusters", clusters_section(input.rate, input.random));
  add_correlation(lines, input);
  lines.add("noise_floor_deg_per_h", input.random.multi_point.floor.deg_per_h);
  lines.add_text("rate", run_json(input.rate));
  lines.add_text("random", run_json(input.random));
  lines.add_text("rate_leave_cycle_out", leave_cycle_out_json(input.models));
  lines.add_text("rate_nested_leave_cycle_out", nested_leave_cycle_out_json(input.models));
  lines.add("improvement", {{"rate", improvement_section(input.rate)}, {"random", improvement_section(input.random)}});
  lines.add_text("models", models_json(input.models));
  lines.add_text("tuning", tuning_json(input.models));
  lines.add_text("methods", methods_json(input));
  lines.add("warnings", warnings(input));
  lines.add("provenance", provenance(input));
  lines.add_text("segments", segments_json(input));
  lines.add_text("series", series_json(input));
  return std::move(lines).finish();
}

}  // namespace gyrotherm
