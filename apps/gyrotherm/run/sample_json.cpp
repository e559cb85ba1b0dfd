// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/run/sample_json.hpp"

#include <cmath>

#include "core/json.hpp"

namespace gyrotherm::app {
namespace {

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json unit_json(const UnitReading& reading, const record::UnitInfo& unit) {
  Json json{{"pulses", Json::object()}, {"interval_s", nullptr}, {"values", Json::object()}};
  const auto* count = reading.count.value ? &*reading.count.value : nullptr;
  for (std::size_t i = 0; i < unit.axes.size(); ++i)
    json["pulses"][unit.axes[i].name.empty() ? unit.name : unit.axes[i].name] =
        count && i < count->pulses.size() ? Json(count->pulses[i]) : Json(nullptr);
  if (count && count->interval > Duration{}) json["interval_s"] = to_seconds(count->interval);
  const auto sent = unit.values.size() - std::min(unit.values.size(), reading.analogue.size());
  for (std::size_t i = 0; i < unit.values.size(); ++i) {
    const auto& name = unit.values[i].name;
    if (i < sent)
      json["values"][name] = count && i < count->values.size() ? number(count->values[i]) : Json(nullptr);
    else
      json["values"][name] =
          reading.analogue[i - sent].value ? number(*reading.analogue[i - sent].value) : Json(nullptr);
  }
  return json;
}

}  // namespace

std::string sample_json(const Sample& sample, std::span<const Event> events, const record::RunInfo& info) {
  const auto chamber = value_of(sample.chamber);
  const auto segment = static_cast<std::size_t>(sample.progress.segment);
  Json json{{"slot", sample.slot},
            {"time_s", to_seconds(sample.at.since_start)},
            {"utc", civil_time(sample.at.utc)},
            {"state", name(sample.state)},
            {"segment", segment < info.segments.size() ? Json(info.segments[segment].name) : Json(nullptr)},
            {"phase", name(sample.progress.phase)},
            {"set_point_c", number(sample.progress.set_point.value)},
            {"chamber_air_c", chamber ? number(chamber->air.value) : Json(nullptr)},
            {"chamber_set_point_c", chamber ? number(chamber->set_point.value) : Json(nullptr)},
            {"thermometers_c", Json::object()},
            {"units", Json::object()},
            {"events", Json::array()}};
  for (std::size_t i = 0; i < sample.thermometers.size() && i < info.thermometers.size(); ++i) {
    const auto reading = value_of(sample.thermometers[i]);
    json["thermometers_c"][info.thermometers[i].name] = reading ? number(reading->value) : Json(nullptr);
  }
  for (std::size_t i = 0; i < sample.units.size() && i < info.units.size(); ++i)
    json["units"][info.units[i].name] = unit_json(sample.units[i], info.units[i]);
  for (const auto& event : events) json["events"].push_back({{"kind", name(event.kind)}, {"text", event.text}});
  return text_of(json);
}

void add_json_of_run(CLI::App& command, std::string& json) {
  command.remove_option(command.get_option("--json"));
  command
      .add_flag("--json{facts}", json,
                "print facts as JSON: how far the record is on the disk; --json=samples: each second, too")
      ->check(CLI::IsMember({"facts", "samples"}));
}

void apply_json_of_run(Console& console, const std::string& json) {
  console.json = !json.empty();
  console.samples = json == "samples";
}

}  // namespace gyrotherm::app
