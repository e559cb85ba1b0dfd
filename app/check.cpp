#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "app/conduct.hpp"
#include "core/text_file.hpp"
#include "rig/rig.hpp"
#include "sequencer/timeline.hpp"
#include "simulator/world.hpp"
#include "simulator/world_parameters.hpp"

namespace gyrotherm {
namespace {

struct Options {
  std::string profile;
  std::string rig;
  bool connect = false;
  std::uint64_t seed = 0;
};

std::string rig_lines(const RigFile& rig) {
  const auto& limits = rig.chamber_limits;
  return fmt::format(
      "{}: {}{}\n  chamber {}, {:g} … {:g} °C, heats at up to {:g}, cools at up to {:g} °C/min, safe at {:g} °C\n"
      "  {} thermometers, gyro {:g} arcsec per pulse\n",
      rig.file, rig.simulated ? "SIMULATED, " : "", rig.title, rig.chamber_map.name, limits.lowest.value,
      limits.highest.value, limits.fastest_heating.value, limits.fastest_cooling.value, rig.safe_set_point.value,
      channels_of(rig).size(), rig.gyro.scale);
}

/// Asks each instrument who it is and reads it once; fails with the first fault, after all have been asked.
Result<void> ask_instruments(Console& console, const RigFile& file, std::uint64_t seed) {
  auto rig = Rig::assemble(file, {.seed = {.gyro = seed, .run = 0}, .already = {}, .replay = {}});
  if (!rig) return failure(rig.error());
  Result<void> all;
  for (const auto& answer : (*rig)->ask()) {
    if (answer)
      console.data("  " + *answer + "\n");
    else if (all)
      all = failure(answer.error());
    else
      console.complain(answer.error());
  }
  return all;
}

std::string timeline_json(const Profile& profile, const Timeline& timeline) {
  const auto total = [](const CycleTotal& cycle) {
    return nlohmann::ordered_json{{"name", cycle.name},
                                  {"seconds", (cycle.ramps + cycle.holds) / std::chrono::seconds(1)},
                                  {"clusters", cycle.clusters}};
  };
  nlohmann::ordered_json json{
      {"profile", profile.name}, {"segments", profile.segments.size()}, {"all", total(timeline.all)}};
  json["cycles"] = nlohmann::ordered_json::array();
  for (const auto& cycle : timeline.cycles) json["cycles"].push_back(total(cycle));
  return json.dump() + "\n";
}

Result<Exit> check(Console& console, const Options& options) {
  if (options.profile.empty() && options.rig.empty())
    return failure(FaultKind::usage, "check", "nothing to check; expected a profile, --rig or both");
  if (options.connect && options.rig.empty())
    return failure(FaultKind::usage, "--connect", "there is no rig to connect to; expected --rig");
  ChamberLimits limits;
  if (!options.rig.empty()) {
    const auto rig = read_rig(options.rig);
    if (!rig) return failure(rig.error());
    if (rig->simulated)
      if (const auto world = parse_world(rig->text, rig->file); !world) return failure(world.error());
    limits = rig->chamber_limits;
    if (!console.json) console.data(rig_lines(*rig));
    if (options.connect)
      if (auto asked = ask_instruments(console, *rig, options.seed); !asked) return failure(asked.error());
  }
  if (options.profile.empty()) return Exit::done;
  const auto profile = read_profile(options.profile, limits);
  if (!profile) return failure(profile.error());
  const auto timeline = plan(*profile);
  console.data(console.json ? timeline_json(*profile, timeline) : describe(*profile, timeline));
  return Exit::done;
}

}  // namespace

void add_check(Program& program) {
  auto options = std::make_shared<Options>();
  auto* command =
      add_command(program, "check", "Checks a profile, a rig, or a profile against a rig; prints the timeline.",
                  "gyrotherm check profiles/qualification.toml --rig profiles/rigs/virtual.toml");
  command->add_option("profile", options->profile, "the profile");
  command->add_option("--rig", options->rig, "the rig");
  command->add_flag("--connect", options->connect, "ask each instrument who it is, and read it once");
  command->add_option("--seed", options->seed, "of a virtual rig")->check(CLI::NonNegativeNumber);
  set_action(command, program, [&program, options] { return check(program.console, *options); });
}

}  // namespace gyrotherm
