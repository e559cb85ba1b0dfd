// SPDX-License-Identifier: Apache-2.0
/// Carries out fault schedules: fault_schedules [--profile FILE] [--first SEED] [--count N] [--none] [--show SEED]
/// [--replay FILE --first SEED] [--reduce]. Exits with code 1 if an invariant was violated.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "tests/sequencer/faults/shrinking.hpp"
#include "tests/sequencer/faults/simulated_run.hpp"

namespace gyrotherm::faults {

namespace {

struct Arguments {
  std::string profile = "tests/sequencer/faults/hour.toml";
  std::string rig = "virtual-reference";
  std::string folder = "/dev/shm";
  std::uint64_t first = 1, count = 1;
  bool none = false, reduce = false;
  std::string replay;
};

Arguments parse_arguments(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    const auto value = [&] { return i + 1 < argc ? std::string(argv[++i]) : std::string(); };
    if (key == "--profile") arguments.profile = value();
    if (key == "--rig") arguments.rig = value();
    if (key == "--folder") arguments.folder = value();
    if (key == "--first") arguments.first = std::strtoull(value().c_str(), nullptr, 10);
    if (key == "--count") arguments.count = std::strtoull(value().c_str(), nullptr, 10);
    if (key == "--none") arguments.none = true;
    if (key == "--reduce") arguments.reduce = true;
    if (key == "--replay") arguments.replay = value();
  }
  return arguments;
}

Schedule read_schedule(const std::string& path) {
  Schedule schedule;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (const auto fault = parse_fault(line)) schedule.push_back(*fault);
  return schedule;
}

int carry_out_schedules(int argc, char** argv) {
  const auto arguments = parse_arguments(argc, argv);
  const auto ground = simulated_setup(arguments.profile, arguments.rig);
  const auto options = options_for(ground);
  std::map<std::string, int> endings, invariants;
  std::array<std::int64_t, 7> states{};
  std::int64_t seconds = 0, failed = 0;
  const auto began = std::chrono::steady_clock::now();
  for (auto seed = arguments.first; seed < arguments.first + arguments.count; ++seed) {
    SimulatedRunSetting setting{.seed = seed, .schedule = {}, .folder = arguments.folder};
    if (!arguments.none)
      setting.schedule = arguments.replay.empty() ? draw_schedule(seed, options) : read_schedule(arguments.replay);
    setting.sync_every = sync_every(seed);
    const auto report = carry_out(ground, setting);
    ++endings[name(report.ending)];
    seconds += report.seconds;
    for (std::size_t i = 0; i < states.size(); ++i) states[i] += report.seconds_in_state[i];
    if (arguments.count == 1)
      fmt::print("seed {}: {} after {} s, {} lives, log {:016x}\n{}", seed, name(report.ending), report.seconds,
                 report.lives, report.log_hash, text(setting.schedule));
    if (report.violations.empty()) continue;
    ++failed;
    for (const auto& violation : report.violations) ++invariants[violation.substr(0, violation.find(' '))];
    fmt::print("seed {}: {}\n", seed, report.violations.front());
    if (arguments.count == 1)
      for (const auto& violation : report.violations) fmt::print("  {}\n", violation);
    if (arguments.reduce) fmt::print("{}", text(shrink_schedule(ground, setting)));
    std::fflush(stdout);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  fmt::print("{} schedules, {} failed, {:.3f} s each, {} virtual seconds\n", arguments.count, failed,
             took.count() / static_cast<double>(arguments.count), seconds);
  for (const auto& [ending, count] : endings) fmt::print("  {}: {}\n", ending, count);
  for (std::size_t i = 0; i < states.size(); ++i)
    fmt::print("  {} s in {}\n", states[i], name(static_cast<RunState>(i)));
  for (const auto& [invariant, count] : invariants) fmt::print("  law {} broken {} times\n", invariant, count);
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace gyrotherm::faults

int main(int argc, char** argv) { return gyrotherm::faults::carry_out_schedules(argc, argv); }
