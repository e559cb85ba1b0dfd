// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/carry_out.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "apps/gyrotherm/run/pace.hpp"
#include "apps/gyrotherm/run/run_goal.hpp"
#include "apps/gyrotherm/run/unit_identification.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::app {
namespace {

struct RunArguments {
  std::string json;
  std::string profile;
  std::string rig;
  std::string out;
  IdentificationOptions identification;
  StartOptions start;
  std::optional<double> until_u;
  std::string pace;
};

/// Returns the file name of a record: "short ramp" gives "short ramp.db". The file is always in the working folder:
/// characters that lead to another folder, hide the file or control a terminal become "_".
std::string make_record_name(const std::string& profile_name) {
  constexpr std::size_t kMaxNameBytes = 100;
  std::string name;
  for (std::string_view left = profile_name; !left.empty() && name.size() < kMaxNameBytes;) {
    const auto size = std::max<std::size_t>(character_size(left), 1);
    const auto character = left.substr(0, size);
    const bool leads = name.empty() && (character == "." || character == "-" || character == " ");
    const bool is_safe = plain(character) == character && character != "/" && character != "\\";
    name += is_safe && !leads ? character : "_";
    left.remove_prefix(size);
  }
  return (name.empty() ? "run" : name) + ".db";
}

Result<Exit> run(Console& console, const RunArguments& options) {
  apply_run_json(console, options.json);
  auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  if (!rig->simulated && options.start.seed != 0)
    return failure(FaultKind::usage, "--seed", "only valid on a virtual rig");
  const auto pace = pace_of_run(options.pace, rig->simulated);
  if (!pace) return failure(pace.error());
  const auto profile = read_profile(options.profile, &*rig);
  if (!profile) return failure(profile.error());
  const auto path = options.out.empty() ? make_record_name(profile->name) : options.out;
  if (auto may = check_may_start(*rig, path, options.start); !may) return failure(may.error());
  auto start = options.start;
  start.pace = *pace;
  auto goal = read_goal(*profile, options.profile, options.until_u);
  if (!goal) return failure(goal.error());
  start.goal = std::move(*goal);
  if (auto may = check_goal(*profile, start.goal, start.upload); !may) return failure(may.error());
  if (auto named = identify_units(console, *rig, options.identification, {path, profile->name, parent_folder(path)});
      !named)
    return failure(named.error());
  watch_for_interrupts(rig->simulated ? SecondInterrupt::ends : SecondInterrupt::is_counted);
  if (auto ran = start_run(console, *profile, *rig, path, start); !ran) return failure(ran.error());
  return Exit::done;
}

}  // namespace

void add_run(Program& program) {
  auto [command, options] = add_command(program, "run", "Runs a profile on a rig and records it second by second.",
                                        "gyrotherm run random --rig virtual --out random.db", run);
  add_run_json_option(command, options.json);
  command.add_option("profile", options.profile, "the profile")->type_name(value::kProfile)->required();
  command.add_option("--rig", options.rig, "the rig")->type_name(value::kRig)->required();
  command.add_option("--out", options.out, "the record (default: the profile's name with .db)")
      ->check(reject_dash())
      ->type_name(value::kRecord);
  add_identification_options(command, options.identification);
  command
      .add_option("--order", options.identification.order,
                  "order.toml: the run accepts only units whose serial numbers it contains")
      ->type_name(value::kToml);
  command.add_option("--seed", options.start.seed, "seed of the virtual gyro and its noise; 0: the gyro of the file")
      ->check(not_negative());
  add_days_later_option(command, options.start.days_later);
  add_pace_option(command, options.pace,
                  "pace of a virtual rig: real, xN for N times real time (such as x60), or max (default)");
  add_accept_air_option(command, options.start.accept_air);
  command
      .add_option("--until-u", options.until_u,
                  "target of the expanded uncertainty, °/h, of a profile with [until] (default: the profile's)")
      ->type_name("U");
  command.add_flag(
      "--upload", options.start.upload,
      "let the controller of the chamber carry out the profile, if its register map describes profile memory");
}

}  // namespace gyrotherm::app
