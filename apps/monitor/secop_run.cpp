// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/secop_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "acquisition/record/run_source.hpp"
#include "core/json.hpp"

namespace gyrotherm::monitor {
namespace {

constexpr double kNsPerS = 1e9;

/// Codes of a status, by their group.
enum class SecopStatus { disabled = 0, idle = 100, warn = 200, busy = 300, error = 400 };

std::string text_info() { return R"({"type":"string","isUTF8":true})"; }

std::string number_info(const std::string& unit, const char* format) {
  return text_of(Json{{"type", "double"}, {"unit", unit}, {"fmtstr", format}});
}

std::string state_info() {
  Json members = Json::object();
  for (const auto state : kRunStates) members[name(state)] = static_cast<int>(state);
  return text_of(Json{{"type", "enum"}, {"members", std::move(members)}});
}

SecopParameter status_of(SecopStatus code, const std::string& words, double utc_s) {
  return {.name = "status",
          .description = "Whether the module has a value, and what the run does.",
          .datainfo =
              R"({"type":"tuple","members":[{"type":"enum","members":)"
              R"({"DISABLED":0,"IDLE":100,"WARN":200,"BUSY":300,"ERROR":400}},{"type":"string","isUTF8":true}]})",
          .value = ascii_of(Json::array({static_cast<int>(code), words})),
          .trouble = {},
          .t = utc_s};
}

std::string state_in_words(const FoundRun& run) {
  return record::in_words(run.status.standing.state, run.status.standing.cause);
}

/// Why no quantity of the run has a value now, as a status and the class of an error.
struct NoValue {
  SecopStatus status{};
  const char* kind{};
  std::string why{};
};

std::optional<NoValue> no_value(const RunMoment& moment) {
  const auto* run = moment.run;
  if (run == nullptr) return NoValue{SecopStatus::disabled, "Disabled", "no run was found"};
  if (!run->is_running())
    return NoValue{SecopStatus::disabled, "Disabled", "no run goes on; the last one: " + state_in_words(*run)};
  if (run->is_silent())
    return NoValue{SecopStatus::error, "CommunicationFailed", "the program that carries the run out does not answer"};
  if (!moment.sample) return NoValue{SecopStatus::warn, "ReadFailed", "the run has no sample yet"};
  if (moment.stale)
    return NoValue{SecopStatus::error, "CommunicationFailed",
                   fmt::format("the run has given no sample for more than {:.0f} s", to_seconds(record::kSilentAfter))};
  return std::nullopt;
}

SecopStatus code_of(const FoundRun& run) {
  switch (run.status.standing.state) {
    case RunState::execute: return SecopStatus::busy;
    case RunState::suspended:
    case RunState::held: return SecopStatus::warn;
    default: return SecopStatus::error;
  }
}

std::optional<Json> left_s(const FoundRun* run) {
  if (run == nullptr || !run->status.standing.time_left) return std::nullopt;
  return Json(std::round(to_seconds(*run->status.standing.time_left)));
}

SecopModule run_module(const RunMoment& moment, const std::string& name) {
  const auto* run = moment.run;
  const auto absent = no_value(moment);
  const bool silent = absent && absent->status != SecopStatus::warn;
  const auto told = [&](const char* word, const char* description, std::string datainfo,
                        const std::optional<Json>& value) {
    SecopParameter parameter{.name = word,
                             .description = description,
                             .datainfo = std::move(datainfo),
                             .value = {},
                             .trouble = value    ? std::string()
                                        : silent ? absent->why
                                                 : "it is not known",
                             .t = moment.utc_s};
    parameter.value = value ? ascii_of(*value) : silent ? absent->kind : "ReadFailed";
    return parameter;
  };
  const auto of_now = [&](std::optional<Json> value) { return silent ? std::nullopt : std::move(value); };
  const auto of_run = [&](const auto& of) { return run != nullptr ? std::optional<Json>(of(*run)) : std::nullopt; };
  return {.name = name,
          .description = "The run that goes on, or the last one.",
          .group = {},
          .parameters = {
              told("value", "The state of the run, after PackML.", state_info(),
                   of_now(of_run([](const FoundRun& r) { return static_cast<int>(r.status.standing.state); }))),
              silent ? status_of(absent->status, absent->why, moment.utc_s)
                     : status_of(code_of(*run), state_in_words(*run), moment.utc_s),
              told("_record", "The name of its record.", text_info(), of_run([](const FoundRun& r) { return r.name; })),
              told("_profile", "The profile that it carries out.", text_info(),
                   of_run([](const FoundRun& r) { return r.info ? r.info->profile_name : std::string(); })),
              told("_simulated", "Whether its rig is a virtual one.", R"({"type":"bool"})",
                   of_run([](const FoundRun& r) { return r.status.simulated; })),
              told("_left", "What is left if every soak counts from now on.", number_info("s", "%.0f"),
                   of_now(left_s(run)))}};
}

std::string description_of(const SeriesChannel& channel) {
  if (channel.name == "set_point_c") return "What the profile asks the chamber for.";
  if (channel.name == "chamber_air_c") return "The chamber's air, as its controller reads it.";
  if (channel.name == "chamber_set_point_c") return "The set point that the chamber's controller has.";
  if (channel.unit_under_test.empty()) return fmt::format("The rig's channel {}, as read.", channel.name);
  return fmt::format("{} of the unit {}, as read.", channel.name, channel.unit_under_test);
}

SecopModule channel_module(const RunMoment& moment, const SeriesChannel& channel, std::size_t index,
                           std::string module_name, std::string group) {
  const auto absent = no_value(moment);
  const auto& sample = moment.sample;
  const double reading = absent || index >= sample->values.size() ? std::nan("") : sample->values[index];
  const bool good = std::isfinite(reading);
  SecopParameter value{.name = "value",
                       .description = "The reading of the last second.",
                       .datainfo = number_info(channel.unit, "%.7g"),
                       .value = {},
                       .trouble = {},
                       .t = sample && std::isfinite(sample->utc_s) ? sample->utc_s : moment.utc_s,
                       .measured = true};
  constexpr const char* kFault = "the instrument gave a fault in place of a reading";
  if (good) {
    value.value = fmt::format("{:.9g}", reading);
  } else {
    value.value = absent ? absent->kind : "HardwareError";
    value.trouble = absent ? absent->why : kFault;
  }
  auto status = absent ? status_of(absent->status, absent->why, moment.utc_s)
                : good ? status_of(SecopStatus::idle, state_in_words(*moment.run), moment.utc_s)
                       : status_of(SecopStatus::error, kFault, moment.utc_s);
  return {.name = std::move(module_name),
          .description = description_of(channel),
          .group = std::move(group),
          .parameters = {std::move(value), std::move(status)}};
}

/// What is told once keeps the time at which it came to be.
void keep_times(const SecopNode& before, SecopNode& now) {
  for (auto& module : now.modules) {
    const auto* old = before.find(module.name);
    if (old == nullptr || old->parameters.size() != module.parameters.size()) continue;
    for (std::size_t i = 0; i < module.parameters.size(); ++i) {
      auto& parameter = module.parameters[i];
      const auto& was = old->parameters[i];
      if (!parameter.measured && was.value == parameter.value && was.trouble == parameter.trouble) parameter.t = was.t;
    }
  }
}

}  // namespace

Result<std::optional<LastSample>> read_last_sample(const FoundRun& run) {
  const auto files = record::source_files(run.path, run.is_running());
  if (!files) return failure(files.error());
  const auto channels = series_channels(*run.info);
  std::string what = "slot, utc_ns";
  for (const auto& channel : channels) what += ", " + channel.sql;
  std::optional<LastSample> last;
  const auto read = record::each_row({files->back()}, {.what = what, .order = "slot DESC", .most = 1},
                                     [&](const record::Statement& row) {
                                       auto& sample = last.emplace();
                                       sample.slot = row.integer(0);
                                       sample.utc_s = row.real(1) / kNsPerS;
                                       constexpr int kBefore = 2;
                                       for (std::size_t i = 0; i < channels.size(); ++i)
                                         sample.values.push_back(row.real(kBefore + static_cast<int>(i)));
                                       return true;
                                     });
  return read.map([&] { return std::move(last); });
}

SecopNode secop_node_of(const RunMoment& moment) {
  const auto info = moment.run != nullptr ? moment.run->info : nullptr;
  const std::string rig = info ? info->rig_name : "no rig";
  SecopNode node{.equipment_id = info ? "gyrotherm_" + rig : "gyrotherm",
                 .description = fmt::format("Temperature chamber and thermometers of the rig {}\n\n"
                                            "The run that goes on, as it is recorded. It can be read, and not changed.",
                                            rig),
                 .firmware = std::string("gyrotherm ") + GYROTHERM_VERSION,
                 .modules = {}};
  std::set<std::string> taken;
  node.modules.push_back(run_module(moment, secop_name("run", taken)));
  if (!info) return node;
  const auto channels = series_channels(*info);
  std::vector<std::string> names;
  for (const auto& channel : channels) names.push_back(secop_name(channel.name, taken));
  std::map<std::string, std::string> groups;  // a group may not be called as a module is
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto& unit = channels[i].unit_under_test;
    if (!groups.contains(unit)) groups[unit] = secop_name(unit.empty() ? "rig" : unit, taken);
    node.modules.push_back(channel_module(moment, channels[i], i, names[i], groups[unit]));
  }
  return node;
}

SecopRun::SecopRun(const RunCatalogue& catalogue, std::string rig, const Clock& clock)
    : catalogue_(catalogue), rig_(std::move(rig)), clock_(clock) {}

std::optional<FoundRun> SecopRun::choose() const {
  if (auto followed = catalogue_.find(key_); followed && followed->is_running() && followed->info) return followed;
  for (auto& run : catalogue_.runs())
    if (run.info && (rig_.empty() || run.info->rig_name == rig_)) return std::move(run);
  return std::nullopt;
}

bool SecopRun::look() {
  const auto now = clock_.now();
  const auto run = choose();
  const auto id = run ? run->key + run->status.id : std::string();
  const bool is_another = id != id_;
  if (is_another) {
    key_ = run ? run->key : std::string();
    id_ = id;
    sample_.reset();
    came_ = now.since_start;
  }
  if (run && run->is_running())
    if (auto read = read_last_sample(*run); read && *read && (!sample_ || (*read)->slot != sample_->slot)) {
      sample_ = std::move(*read);
      came_ = now.since_start;
    }
  auto node = secop_node_of({.run = run ? &*run : nullptr,
                             .sample = sample_,
                             .stale = now.since_start - came_ > record::kSilentAfter,
                             .utc_s = to_seconds(now.utc)});
  if (!is_another) keep_times(state_.node, node);
  auto structure = structure_of(node);
  const bool changed = structure != state_.structure;
  state_ = {std::move(node), std::move(structure)};
  return changed;
}

}  // namespace gyrotherm::monitor
