#include "acquisition/status.hpp"

#include <fmt/format.h>

#include "app/command.hpp"

namespace gyrotherm {
namespace {

std::string degrees(const std::optional<Celsius>& value) {
  return value ? fmt::format("{:.2f} °C", value->value) : "unknown";
}

std::string words(const RunStatus& status) {
  const char* standing = status.finished        ? "finished"
                         : status.being_written ? "running"
                                                : "not finished; resume goes on";
  auto text = fmt::format("{}{}: {}\n", status.simulated ? "SIMULATED " : "", status.path, standing);
  text += fmt::format("  up to second {}, acknowledged up to {}, {} faulty readings\n", status.slot,
                      status.acknowledged, status.faults);
  if (status.segment_count > 0)
    text += fmt::format("  segment {} of {}, {}: {}\n", status.segment_index + 1, status.segment_count, status.segment,
                        name(status.phase));
  if (const auto& frames = status.frames)
    text += fmt::format("  frames of the gyro: {} seen, {} lost, {} bad\n", frames->seen, frames->lost, frames->bad);
  text += fmt::format("  set point {}, air {}\n ", degrees(status.set_point), degrees(status.chamber_air));
  for (const auto& thermometer : status.thermometers)
    text += fmt::format(" {} {}", thermometer.channel, degrees(thermometer.reading));
  return text + "\n";
}

Result<Exit> show(Console& console, const std::string& path) {
  const auto status = read_status(path);
  if (!status) return failure(status.error());
  console.data(console.json ? to_json(*status) + "\n" : words(*status));
  return Exit::done;
}

}  // namespace

void add_status(Program& program) {
  auto path = std::make_shared<std::string>();
  auto* command = add_command(program, "status", "Tells where a running or finished run stands; safe while it runs.",
                              "gyrotherm status random.db");
  command->add_option("run", *path, "the record")->required();
  set_action(command, program, [&program, path] { return show(program.console, *path); });
}

}  // namespace gyrotherm
