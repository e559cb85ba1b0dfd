// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <poll.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "apps/console/command.hpp"
#include "apps/console/interrupt.hpp"
#include "apps/gyrotherm/rig_source.hpp"
#include "apps/gyrotherm/run/pace.hpp"
#include "sequencer/rig/rig.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono::steady_clock;

struct SimulateArguments {
  std::string rig = "virtual";
  std::string pace = "real";
  std::uint64_t seed = 0;
  std::uint16_t port = 0;
  bool full_rate = false;
  bool pty = false;
};

constexpr auto kWallStep = std::chrono::milliseconds(10);  // wall time between two advances

std::string to_string(const drivers::MapLink& link, bool serial) {
  if (serial) return "Modbus RTU";
  return link.kind == drivers::LinkKind::tcp ? "Modbus TCP" : "Modbus RTU over TCP";
}

std::string modbus_in_words(const drivers::RegisterMap& map, const simulator::ServedLine& served) {
  const bool serial = served.line.starts_with("serial:");
  if (map.text_link) return fmt::format("text protocol of {}", map.name);
  const auto* rtu = serial ? map.find(drivers::LinkKind::rtu) : nullptr;
  const auto& link = rtu ? *rtu : map.link;
  return fmt::format("{}, unit {}, {}", to_string(link, serial), link.modbus.unit, map.name);
}

/// Describes the protocol and instrument on a line: "Modbus TCP, unit 1, Watlow F4T".
std::string describe_line(const rig::RigFile& rig, const simulator::ServedLine& served) {
  if (served.instrument == "chamber") return modbus_in_words(rig.chamber_map, served);
  for (const auto& line : rig.gyro_lines)
    if (served.instrument == line_title(line, rig.units)) return fmt::format("frames: {}", line.frame.name);
  for (std::size_t i = 0; i < rig.thermometers.size(); ++i)
    if (served.instrument == fmt::format("thermometer {}", i + 1))
      return fmt::format("{}: {}", rig.thermometers[i].driver, fmt::join(rig.thermometers[i].channels, " "));
  for (std::size_t i = 0; i < rig.analogue_inputs.size(); ++i)
    if (served.instrument == rig::analogue_title(i))
      return modbus_in_words(rig.analogue_inputs[i].map.registers, served);
  for (std::size_t i = 0; i < rig.supplies.size(); ++i)
    if (served.instrument == rig::supply_title(i))
      return fmt::format("text protocol of {}", rig.supplies[i].description.unit.name);
  return {};
}

void print_addresses(Console& console, const rig::RigFile& rig, const simulator::VirtualInstruments& instruments) {
  std::string text;
  for (const auto& served : instruments.lines())
    text += console.json ? fmt::format("{{\"instrument\": \"{}\", \"line\": \"{}\"}}\n", served.instrument, served.line)
                         : fmt::format("{:<14} {}  {}\n", served.instrument, served.line, describe_line(rig, served));
  console.print(text);
  for (std::size_t i = 0; i < rig.thermometers.size(); ++i)
    if (instruments.thermometer_port(i) == 0)
      console.print_message(
          fmt::format("thermometer {} ({}) is an HID device; it exists only in dry runs, and no other program "
                      "can open it",
                      i + 1, rig.thermometers[i].driver));
}

/// Waits for `time` or a signal. Returns false once a signal has arrived.
bool wait(steady_clock::duration time) {
  pollfd descriptor{interrupt_descriptor(), POLLIN, 0};
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(time).count();
  ::poll(&descriptor, 1, static_cast<int>(std::max<std::int64_t>(0, ms)));
  return !interrupted();
}

void advance_time(simulator::VirtualInstruments& instruments, double pace) {
  const auto began = steady_clock::now();
  Duration passed{};
  while (!interrupted()) {
    if (pace == 0) {
      instruments.advance(1);
      continue;
    }
    if (!wait(kWallStep)) return;
    const auto now = std::chrono::duration_cast<Duration>((steady_clock::now() - began) * pace);
    instruments.pass(now - std::exchange(passed, now));
  }
}

Result<Exit> simulate(Console& console, const SimulateArguments& options) {
  const auto pace = parse_pace(options.pace);
  if (!pace) return failure(pace.error());
  const auto rig = load_rig(options.rig);
  if (!rig) return failure(rig.error());
  watch_for_interrupts(SecondInterrupt::ends);
  const bool is_full_rate = options.full_rate || !rig->simulated;
  const auto frames = is_full_rate ? simulator::FramePace::full_rate : simulator::FramePace::one_a_second;
  auto instruments = rig::serve_virtual(*rig, {.gyro = options.seed, .run = 0},
                                        {.first_port = options.port, .frames = frames, .ptys = options.pty});
  if (!instruments) return failure(instruments.error());
  console.print_message(fmt::format("SIMULATED instruments of {}; Ctrl-C stops them", rig->file));
  print_addresses(console, *rig, **instruments);
  advance_time(**instruments, *pace);
  return Exit::done;
}

}  // namespace

void add_simulate(Program& program) {
  auto [command, options] =
      add_command(program, "simulate", "Serves the virtual instruments on loopback until stopped, for any client.",
                  "gyrotherm simulate --rig virtual --pace x10", simulate);
  command
      .add_option("--rig", options.rig,
                  "a rig (default: virtual); for a real rig with one axis, virtual instruments of the same types")
      ->type_name(value::kRig);
  add_pace_option(command, options.pace, "real, max, or xN for N times real time (such as x10)");
  command.add_option("--seed", options.seed, "seed of the virtual gyro and its noise; 0: the gyro of the file")
      ->check(not_negative());
  command
      .add_option("--port", options.port,
                  "port of the chamber; the other instruments use the following ports (default: free ports)")
      ->check(CLI::Range(std::numeric_limits<std::uint16_t>::max()));
  command.add_flag(
      "--full-rate", options.full_rate,
      "for a virtual rig: send frames at the full rate of each gyro stream instead of one per second; for a real "
      "rig this is the default");
  command.add_flag("--pty", options.pty, "also serve instruments with a serial line on pseudo-terminals");
}

}  // namespace gyrotherm::app
