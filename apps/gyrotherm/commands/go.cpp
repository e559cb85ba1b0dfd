// SPDX-License-Identifier: Apache-2.0
/// The command `go`: one manual set point, executed as a run of a single hold with all protection of a run.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <ctime>
#include <regex>
#include <string>

#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/carry_out.hpp"
#include "apps/gyrotherm/run/checked_profile.hpp"
#include "core/clock.hpp"
#include "core/program_start.hpp"
#include "core/quantity.hpp"

namespace gyrotherm::app {
namespace {

struct GoArguments {
  std::string rig;
  double at{};
  std::string time = "24 h";
  std::string out;
  StartOptions start;
};

/// Refuses a set point in the place of the rig.
CLI::Validator reject_number() {
  return {[](const std::string& rig) {
            return value_refusal_reason(rig, "FLOAT").empty()
                       ? fmt::format("\"{}\" is a set point, expected the rig before it", rig)
                       : std::string();
          },
          ""};
}

/// Returns "go-2026-11-25-224503.db", in UTC.
std::string default_record_name() {
  const auto seconds = SteadyClock().now().utc / std::chrono::seconds(1);
  return fmt::format("go-{:%Y-%m-%d-%H%M%S}.db", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

// Returns the text of a profile that moves to the set point and holds it.
std::string profile_text(const GoArguments& options) {
  return fmt::format(R"(schema = "gyrotherm-profile/1"
name = "go to {0:g} °C"

[[segment]]
kind = "hold"
at = {0}
time = "{1}"
)",
                     options.at, options.time);
}

/// Returns a fault about the set point or the time, without the positions in the generated profile.
tl::unexpected<Fault> argument_fault(const Fault& fault) {
  static const std::regex position(R"((^|\n)go:\d+:\d+: )");
  return failure(FaultKind::usage, "", std::regex_replace(text(fault), position, "$1"));
}

Result<Exit> go(Console& console, const GoArguments& options) {
  const auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  if (const auto time = parse_duration(options.time); !time)
    return failure(FaultKind::usage, "--for", time.error().what);
  const auto profile = parse_checked_profile(&*rig, profile_text(options), "go");
  if (!profile) return argument_fault(profile.error());
  watch_for_interrupts(rig->simulated ? SecondInterrupt::ends : SecondInterrupt::is_counted);
  const auto path = options.out.empty() ? default_record_name() : options.out;
  if (auto ran = start_run(console, *profile, *rig, path, options.start); !ran) return failure(ran.error());
  return Exit::done;
}

}  // namespace

void add_go(Program& program) {
  auto [command, options] = add_command(
      program, "go",
      "Brings the chamber of a rig to one temperature and holds it there, with the interlocks and the record of a run.",
      "gyrotherm go virtual 25 --for \"2 h\"", go);
  command.add_option("rig", options.rig, "the rig")->check(reject_number())->type_name(value::kRig)->required();
  command.add_option("at", options.at, "the set point, °C")->required();
  command.add_option("--for", options.time, "duration of the hold (default: 24 h)");
  command.add_option("--out", options.out, "the record (default: go-DATE-TIME.db, in UTC)")
      ->check(reject_dash())
      ->type_name(value::kRecord);
  add_accept_air_option(command, options.start.accept_air);
}

}  // namespace gyrotherm::app
