#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/data/hold_noise.hpp"
#include "report/json_pieces.hpp"
#include "report/report_json_parts.hpp"

namespace gyrotherm {
namespace {

using Json = nlohmann::ordered_json;

Json figures(const Figures& f) { return json_of<Json>(f); }

Json verified(const Verification& verification) {
  Json json = figures(verification.compensated);
  json["ramps"] = figures(verification.ramps);
  json["holds"] = figures(verification.holds);
  json["corners"] = figures(verification.corners);
  json["outside_trained_range"] = verification.outside.clusters;
  json["outside"] = json_of<Json>(verification.outside);
  json["effective_parameters"] = json_if_known<Json>(verification.effective_parameters);
  json["expected_in_sample_std_deg_per_h"] = verification.expected_in_sample_std;
  return json;
}

Json gaps(const Dataset& dataset) {
  Json array = Json::array();
  for (const auto& [from, to] : dataset.gaps_s) array.push_back({from, to});
  return array;
}

/// Of the holds, and of the whole run before and after compensation.
Json allan(const ReportedRun& run) {
  Json json = json_of<Json>(run.noise);
  json["compensated_holds"] = json_of<Json>(run.compensated_noise);
  json["whole_run"] = {{"raw", json_of<Json>(allan_curve_of(run.clusters.bias_deg_per_h, run.clusters))}};
  for (const auto& [key, verification] : by_key(run)) {
    json["whole_run"][key] = json_of<Json>(allan_curve_of(verification->residual_deg_per_h, run.clusters));
  }
  return json;
}

Json thermometers(const Clusters& clusters) {
  Json json = Json::object();
  for (std::size_t k = 0; k < clusters.thermometers.size(); ++k) {
    json[clusters.thermometers[k]] = json_list<Json>(clusters.temperature_c.col(static_cast<Eigen::Index>(k)));
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

Json series(const ReportedRun& run) {
  const auto list = [](const Eigen::VectorXd& values) { return json_list<Json>(values); };
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

}  // namespace

std::string run_json(const ReportedRun& run) {
  Json json;
  json["in_sample"] = std::ranges::any_of(by_key(run), [](const auto& entry) { return entry.second->trained_on_this; });
  json["profile"] = run.dataset.profile_name;
  json["run_id"] = run.dataset.run_id;
  json["bias_zero"] = run.dataset.bias_zero;
  json["noise_floor_deg_per_h"] = run.multi_point.floor.deg_per_h;
  json["noise_floor_error_deg_per_h"] = run.multi_point.floor.error_deg_per_h;
  json["noise_floor_differences"] = run.multi_point.floor.differences;
  json["allan"] = allan(run);
  json["gaps_s"] = gaps(run.dataset);
  json["raw"] = figures(run.multi_point.raw);
  for (const auto& [key, verification] : by_key(run)) json[key] = verified(*verification);
  return text_of(json);
}

std::string segments_json(const ReportInput& input) {
  Json array = Json::array();
  add_segments(array, "rate", input.rate);
  add_segments(array, "random", input.random);
  return text_of(array);
}

std::string series_json(const ReportInput& input) {
  return text_of(Json{{"rate", series(input.rate)}, {"random", series(input.random)}});
}

}  // namespace gyrotherm
