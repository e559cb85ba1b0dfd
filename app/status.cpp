#include "acquisition/status.hpp"

#include <fmt/format.h>

#include "acquisition/chain_check.hpp"
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

/// Whether the record is as it was written. A record being written is not opened.
Result<Exit> verify(Console& console, const std::string& path) {
  const auto verified = verify_record(path);
  if (!verified) return failure(verified.error());
  console.data(console.json ? fmt::format("{{\"rows\": {}, \"files\": {}, \"finished\": {}, \"manifest\": {}}}\n",
                                          verified->rows, verified->files, verified->finished, verified->manifest)
                            : fmt::format("{}: all {} rows are as they were written{}\n", path, verified->rows,
                                          verified->manifest ? ", and so is every byte" : ""));
  return Exit::done;
}

}  // namespace

void add_status(Program& program) {
  auto path = std::make_shared<std::string>();
  auto chain = std::make_shared<bool>(false);
  auto* command = add_command(program, "status", "Tells where a running or finished run stands; safe while it runs.",
                              "gyrotherm status random.db");
  command->add_option("run", *path, "the record")->required();
  command->add_flag("--verify", *chain,
                    "checks the record against its chain, and against the manifest it was closed with");
  set_action(command, program, [&program, path, chain] {
    return *chain ? verify(program.console, *path) : show(program.console, *path);
  });
}

}  // namespace gyrotherm
