// SPDX-License-Identifier: Apache-2.0
#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "app/places.hpp"
#include "app/run/carry_out.hpp"

namespace gyrotherm::app {
namespace {

struct RunArguments {
  std::string profile;
  std::string rig;
  std::string out;
  std::uint64_t seed = 0;
  bool upload = false;
};

Result<Exit> run(Console& console, const RunArguments& options) {
  const auto rig = rig::read_rig(options.rig);
  if (!rig) return failure(rig.error());
  const auto profile = read_profile(options.profile, &*rig);
  if (!profile) return failure(profile.error());
  watch_for_interrupts(rig->simulated ? SecondInterrupt::ends : SecondInterrupt::is_counted);
  const auto path = options.out.empty() ? record_named_after(profile->name) : options.out;
  if (auto ran = start_run(console, *profile, *rig, options.seed, path, options.upload); !ran)
    return failure(ran.error());
  return Exit::done;
}

}  // namespace

void add_run(Program& program) {
  auto options = std::make_shared<RunArguments>();
  auto command = add_command(program, "run", "Runs one profile on a rig and records it, a second at a time.",
                             "gyrotherm run profiles/random.toml --rig profiles/rigs/virtual.toml --out random.db");
  command.option("profile", options->profile, "the profile").required();
  command.option("--rig", options->rig, "the rig").required();
  command.option("--out", options->out, "the record (default: the profile's name with .db)");
  command.option("--seed", options->seed, "draws the virtual gyro and its noise; 0 is the gyro of the file")
      .not_negative();
  command.flag("--upload", options->upload,
               "the chamber's controller carries the profile out by itself, where its map describes how");
  command.action([&program, options] { return run(program.console, *options); });
}

}  // namespace gyrotherm::app
