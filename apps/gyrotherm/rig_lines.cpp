// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/rig_lines.hpp"

#include <fmt/format.h>

#include <variant>

#include "acquisition/record/run_info.hpp"
#include "core/clock.hpp"
#include "drivers/line/byte_streams.hpp"
#include "simulator/laboratory_parameters.hpp"

namespace gyrotherm::app {

std::vector<Connected> instrument_lines(const rig::RigFile& rig) {
  std::vector<Connected> lines{{"chamber", rig.chamber_line, rig.chamber_map.link.modbus.port}};
  for (std::size_t i = 0; i < rig.thermometers.size(); ++i)
    lines.push_back({.title = fmt::format("thermometer {}", i + 1),
                     .line = rig.thermometers[i].line,
                     .program = rig.simulated ? drivers::ProgramCommand{} : rig.thermometers[i].command});
  for (const auto& gyro : rig.gyro_lines) lines.push_back({title_of(gyro, rig.units), gyro.line});
  for (std::size_t i = 0; i < rig.analogue_inputs.size(); ++i)
    lines.push_back({rig::title_of_analogue(i), rig.analogue_inputs[i].line,
                     rig.analogue_inputs[i].map.registers.link.modbus.port});
  return lines;
}

std::string unstable_name(const std::string& line) {
  const auto parsed = drivers::parse_line(line);
  const auto* serial = parsed ? std::get_if<drivers::SerialLine>(&*parsed) : nullptr;
  if (serial == nullptr || !drivers::has_unstable_name(serial->device)) return {};
  auto stable = *serial;
  stable.device = drivers::stable_name(serial->device);
  return fmt::format("{} depends on the order in which adapters are plugged in, expected {}", serial->device,
                     stable.device.empty() ? "its name in /dev/serial/by-id (\"gyrotherm devices\" lists them)"
                                           : fmt::format("\"{}\"", text(drivers::Line(stable))));
}

std::vector<std::string> overdue(const rig::RigFile& rig) {
  return overdue_calibrations(channels_of(rig), rig.simulated ? kVirtualEpoch : SteadyClock().now().utc);
}

}  // namespace gyrotherm::app
