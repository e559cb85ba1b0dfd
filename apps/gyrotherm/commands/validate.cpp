// SPDX-License-Identifier: Apache-2.0
/// The command `validate`: the qualification of an installation and of a rig, with a protocol.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/validate/requirements.hpp"
#include "apps/gyrotherm/validate/validation.hpp"
#include "core/clock.hpp"
#include "core/process.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::app {
namespace {

struct ValidateArguments {
  std::string rig, out, by;
  report::SigningKey key;
};

Result<void> make_validation_folder(const std::string& folder) {
  std::error_code error;
  if (std::filesystem::exists(folder, error))
    return failure(FaultKind::usage, folder, "exists already; a validation gets a folder of its own");
  if (!std::filesystem::create_directories(folder, error)) return failure(FaultKind::storage, folder, error.message());
  return {};
}

std::string describe(const RequirementResult& result) {
  return fmt::format("{:<5} {:<14} {}\n      {}\n", result.id, name(result.verdict), result.english, result.evidence);
}

Result<Exit> validate(Console& console, const ValidateArguments& options) {
  if (auto complete = check_signing_options(options.key); !complete) return failure(complete.error());
  const auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  if (auto made = make_validation_folder(options.out); !made) return failure(made.error());
  watch_for_interrupts(SecondInterrupt::ends);
  Validation validation{.rig = rig->name,
                        .title = rig->title,
                        .rig_file = rig->file,
                        .rig_sha256 = sha256(rig->text),
                        .simulated = rig->simulated,
                        .version = GYROTHERM_VERSION,
                        .operator_name = options.by.empty() ? describe_user(::geteuid()) : options.by,
                        .began = civil_time(SteadyClock().now().utc),
                        .ended = ""};
  validation.programs = list_installed_programs();
  const auto show = [&](const RequirementResult& result) {
    console.print_message(fmt::format("{} {}", result.id, name(result.verdict)));
    return !interrupted();
  };
  auto results = test_requirements({*rig, options.out}, show);
  if (!results) return failure(results.error());
  validation.results = std::move(*results);
  validation.ended = civil_time(SteadyClock().now().utc);
  const auto kind = validation_protocol();
  if (auto written = write_protocol(options.out, kind, to_json(validation)); !written) return failure(written.error());
  if (!options.key.key_file.empty())
    if (auto done = sign_protocol(options.out, kind, options.key); !done) return failure(done.error());
  std::string words = validation.simulated ? "SIMULATED: the rig is virtual\n" : "";
  for (const RequirementResult& result : validation.results) words += describe(result);
  console.print_report(console.json ? to_json(validation) : words);
  console.print_message(
      fmt::format("{}: protocol{}", options.out, options.key.key_file.empty() ? ", UNSIGNED" : ", signed"));
  return overall_verdict(validation) == ValidationVerdict::passed ? Exit::done : Exit::outside_limits;
}

}  // namespace

void add_validate(Program& program) {
  auto [command, options] =
      add_command(program, "validate",
                  "Qualifies the installation and its operation with a rig: tests each requirement and writes a "
                  "protocol. It sends nothing to an instrument.",
                  "gyrotherm validate --rig virtual --out validation", validate);
  command.add_option("--rig", options.rig, "the rig")->type_name(value::kRig)->required();
  command.add_option("--out", options.out, "a new folder for the protocol and its records")
      ->check(reject_dash())
      ->type_name(value::kFolder)
      ->required();
  command.add_option("--by", options.by, "the operator (default: this user)")->type_name("NAME");
  add_signing_options(command, options.key);
}

}  // namespace gyrotherm::app
