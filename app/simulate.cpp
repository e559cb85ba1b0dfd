#include <fmt/format.h>
#include <poll.h>

#include <chrono>
#include <optional>

#include "app/command.hpp"
#include "app/interrupt.hpp"
#include "app/places.hpp"
#include "rig/rig.hpp"

namespace gyrotherm {
namespace {

using std::chrono::steady_clock;

struct Options {
  std::string rig;
  std::string pace = "real";
  std::uint64_t seed = 0;
  std::uint16_t port = 0;
};

/// Seconds of the world per second of wall time; 0: as fast as the machine goes. Nothing if the text is no pace.
std::optional<double> pace_of(const std::string& text) {
  if (text == "real") return 1;
  if (text == "max") return 0;
  if (!text.starts_with('x')) return {};
  char* end = nullptr;
  const double factor = std::strtod(text.c_str() + 1, &end);
  if (*end != '\0' || !(factor > 0) || factor > 1e6) return {};
  return factor;
}

void print_addresses(Console& console, const RigFile& rig, const VirtualInstruments& instruments) {
  std::string text;
  const auto line = [&](std::string_view what, std::uint16_t port, std::string_view how) {
    text += console.json ? fmt::format("{{\"instrument\": \"{}\", \"line\": \"tcp://127.0.0.1:{}\"}}\n", what, port)
                         : fmt::format("{:<14} tcp://127.0.0.1:{}  {}\n", what, port, how);
  };
  line("chamber", instruments.chamber_port(),
       fmt::format("Modbus TCP, unit {}, {}", rig.chamber_map.unit, rig.chamber_map.name));
  for (std::size_t i = 0; i < rig.thermometers.size(); ++i)
    line(fmt::format("thermometer {}", i + 1), instruments.thermometer_port(i),
         fmt::format("{}: {}", rig.thermometers[i].driver, fmt::join(rig.thermometers[i].channels, " ")));
  line("gyro", instruments.gyro_port(), fmt::format("frames: {}", rig.gyro_frame.name));
  console.data(text);
}

/// Waits for at most that long; false once the user wants to stop.
bool wait(steady_clock::duration time) {
  pollfd descriptor{interrupt_descriptor(), POLLIN, 0};
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(time).count();
  ::poll(&descriptor, 1, static_cast<int>(std::max<std::int64_t>(0, ms)));
  return !interrupted();
}

void let_time_pass(VirtualInstruments& instruments, double pace) {
  const auto began = steady_clock::now();
  std::int64_t passed = 0;
  while (!interrupted()) {
    if (pace == 0) {
      instruments.advance(1);
      continue;
    }
    const auto due = began + std::chrono::duration_cast<steady_clock::duration>(
                                 std::chrono::duration<double>(static_cast<double>(passed + 1) / pace));
    if (!wait(due - steady_clock::now())) return;
    instruments.advance(1);
    ++passed;
  }
}

Result<Exit> simulate(Console& console, const Options& options) {
  const auto pace = pace_of(options.pace);
  if (!pace)
    return failure(FaultKind::usage, "--pace",
                   fmt::format("\"{}\" is no pace, expected real, max or x10", options.pace));
  const auto rig = read_rig(options.rig.empty() ? shipped("profiles/rigs/virtual.toml") : options.rig);
  if (!rig) return failure(rig.error());
  auto instruments = serve_virtual(*rig, {.gyro = options.seed, .run = 0}, options.port);
  if (!instruments) return failure(instruments.error());
  console.say(fmt::format("SIMULATED instruments of {}; Ctrl-C stops them", rig->file));
  print_addresses(console, *rig, **instruments);
  let_time_pass(**instruments, *pace);
  return Exit::done;
}

}  // namespace

void add_simulate(Program& program) {
  auto options = std::make_shared<Options>();
  auto* command =
      add_command(program, "simulate", "Serves the virtual instruments on loopback until stopped, for any client.",
                  "gyrotherm simulate --rig profiles/rigs/virtual.toml --pace x10");
  command->add_option("--rig", options->rig, "a virtual rig (default: profiles/rigs/virtual.toml)");
  command->add_option("--pace", options->pace, "real, max, or x10 for ten times real time");
  command->add_option("--seed", options->seed, "draws the virtual gyro and its noise; 0 is the gyro of the file")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--port", options->port, "the chamber's port, the others follow (default: any free ones)");
  set_action(command, program, [&program, options] { return simulate(program.console, *options); });
}

}  // namespace gyrotherm
