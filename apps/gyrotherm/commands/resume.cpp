// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/chain.hpp"
#include "acquisition/record/status.hpp"
#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/run/carry_out.hpp"
#include "apps/gyrotherm/run/pace.hpp"
#include "apps/gyrotherm/run/unit_identification.hpp"
#include "core/toml_reader.hpp"

namespace gyrotherm::app {
namespace {

struct ResumeArguments {
  std::string json;
  std::string run;
  bool accept = false;
  bool trust_commands = false;
  std::string gap = "30 s";
  std::vector<std::string> units;
  std::string pace;
};

Result<Exit> resume(Console& console, const ResumeArguments& options) {
  apply_run_json(console, options.json);
  const auto gap = parse_duration(options.gap);
  if (!gap) return failure(FaultKind::usage, "--gap", gap.error().what);
  // resume_run() reports a record that cannot be read. Until that call, Ctrl-C ends the program immediately.
  const auto status = record::read_status(options.run);
  const bool is_virtual = status && is_in_virtual_time(*status);
  const auto pace = pace_of_run(options.pace, !status || is_virtual);
  if (!pace) return failure(pace.error());
  // A virtual run is replayed from the record before the record is opened for writing. Its files are verified first.
  if (is_virtual)
    if (const auto whole = record::find_record_files(options.run).and_then(record::verify_files); !whole)
      return failure(whole.error());
  watch_for_interrupts(is_virtual ? SecondInterrupt::ends : SecondInterrupt::is_counted);
  if (auto ran = resume_run(console, options.run,
                            {.accept = options.accept,
                             .trust_commands = options.trust_commands,
                             .gap = *gap,
                             .units = options.units,
                             .pace = *pace});
      !ran)
    return failure(ran.error());
  return Exit::done;
}

}  // namespace

void add_resume(Program& program) {
  auto [command, options] = add_command(program, "resume", "Resumes a run after a crash, a power cut or Ctrl-C.",
                                        "gyrotherm resume random.db", resume);
  add_run_json_option(command, options.json);
  command.add_option("run", options.run, "the record")->type_name(value::kRecord)->required();
  command.add_flag("--accept", options.accept,
                   "confirm that the operator has checked the chamber and that the run may continue");
  command.add_flag("--trust-commands", options.trust_commands,
                   "start the driver programs that the record names, even if this user has not confirmed their "
                   "present versions by a run of this rig file");
  command.add_option("--gap", options.gap, "on a virtual rig: length of the interruption (default: 30 s)")
      ->type_name("DURATION");
  add_pace_option(command, options.pace, "on a virtual rig: as for run (default: max)");
  add_unit_option(command, options.units);
}

}  // namespace gyrotherm::app
