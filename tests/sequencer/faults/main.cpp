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

struct Wanted {
  std::string profile = "tests/sequencer/faults/hour.toml";
  std::string rig = "virtual-reference";
  std::string folder = "/dev/shm";
  std::uint64_t first = 1, count = 1;
  bool none = false, reduce = false;
  std::string replay;
};

Wanted wanted_by(int argc, char** argv) {
  Wanted wanted;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    const auto value = [&] { return i + 1 < argc ? std::string(argv[++i]) : std::string(); };
    if (key == "--profile") wanted.profile = value();
    if (key == "--rig") wanted.rig = value();
    if (key == "--folder") wanted.folder = value();
    if (key == "--first") wanted.first = std::strtoull(value().c_str(), nullptr, 10);
    if (key == "--count") wanted.count = std::strtoull(value().c_str(), nullptr, 10);
    if (key == "--none") wanted.none = true;
    if (key == "--reduce") wanted.reduce = true;
    if (key == "--replay") wanted.replay = value();
  }
  return wanted;
}

Schedule read_schedule(const std::string& path) {
  Schedule schedule;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (const auto fault = parse_fault(line)) schedule.push_back(*fault);
  return schedule;
}

int carry_out_schedules(int argc, char** argv) {
  const auto wanted = wanted_by(argc, argv);
  const auto ground = simulated_setup(wanted.profile, wanted.rig);
  const auto options = options_for(ground);
  std::map<std::string, int> endings, invariants;
  std::array<std::int64_t, 7> states{};
  std::int64_t seconds = 0, failed = 0;
  const auto began = std::chrono::steady_clock::now();
  for (auto seed = wanted.first; seed < wanted.first + wanted.count; ++seed) {
    SimulatedRunSetting setting{.seed = seed, .schedule = {}, .folder = wanted.folder};
    if (!wanted.none)
      setting.schedule = wanted.replay.empty() ? draw_schedule(seed, options) : read_schedule(wanted.replay);
    setting.sync_every = sync_every(seed);
    const auto report = carry_out(ground, setting);
    ++endings[name(report.ending)];
    seconds += report.seconds;
    for (std::size_t i = 0; i < states.size(); ++i) states[i] += report.seconds_in_state[i];
    if (wanted.count == 1)
      fmt::print("seed {}: {} after {} s, {} lives, log {:016x}\n{}", seed, name(report.ending), report.seconds,
                 report.lives, report.log_hash, text(setting.schedule));
    if (report.violations.empty()) continue;
    ++failed;
    for (const auto& violation : report.violations) ++invariants[violation.substr(0, violation.find(' '))];
    fmt::print("seed {}: {}\n", seed, report.violations.front());
    if (wanted.count == 1)
      for (const auto& violation : report.violations) fmt::print("  {}\n", violation);
    if (wanted.reduce) fmt::print("{}", text(reduced(ground, setting)));
    std::fflush(stdout);
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  fmt::print("{} schedules, {} failed, {:.3f} s each, {} virtual seconds\n", wanted.count, failed,
             took.count() / static_cast<double>(wanted.count), seconds);
  for (const auto& [ending, count] : endings) fmt::print("  {}: {}\n", ending, count);
  for (std::size_t i = 0; i < states.size(); ++i)
    fmt::print("  {} s in {}\n", states[i], name(static_cast<RunState>(i)));
  for (const auto& [invariant, count] : invariants) fmt::print("  law {} broken {} times\n", invariant, count);
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace gyrotherm::faults

int main(int argc, char** argv) { return gyrotherm::faults::carry_out_schedules(argc, argv); }
