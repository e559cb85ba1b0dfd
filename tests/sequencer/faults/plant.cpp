// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/plant.hpp"

#include <algorithm>
#include <string_view>

#include "core/random.hpp"
#include "simulator/servers/supply_server.hpp"
#include "simulator/servers/virtual_thermometers.hpp"

namespace gyrotherm::faults {
namespace {

simulator::Lakeshore218Session::Inputs make_inputs(const rig::ThermometerSettings& entry,
                                                   const simulator::VirtualLaboratory& laboratory) {
  simulator::Lakeshore218Session::Inputs inputs;
  const auto& names = laboratory.thermometer_names();
  for (std::size_t i = 0; i < entry.channels.size(); ++i)
    inputs[i] = static_cast<std::size_t>(std::ranges::find(names, entry.channels[i]) - names.begin());
  return inputs;
}

/// Replaces the serial number in the answer to *IDN? by that of another instrument.
void replace_serial_number(Bytes& answer) {
  constexpr std::string_view kOwn = "VIRTUAL1", kAnother = "VIRTUAL2";
  const auto same = [](std::byte byte, char c) { return static_cast<char>(byte) == c; };
  const auto found = std::ranges::search(answer, kOwn, same);
  std::ranges::transform(kAnother.substr(0, found.size()), found.begin(), [](char c) { return std::byte(c); });
}

}  // namespace

Plant::Plant(const rig::RigFile& file, const simulator::LaboratoryParameters& parameters, const Clock& rig,
             std::uint64_t seed)
    : laboratory_(parameters, {.gyro = 0, .run = seed}),
      faults(laboratory_.thermometer_names().size()),
      registers_(file.chamber_map, laboratory_),
      chamber_port_(registers_, laboratory_, rig, splitmix64(seed)) {
  for (std::size_t i = 0; i < file.gyro_lines.size(); ++i)
    gyros_.push_back(std::make_unique<GyroEnd>(file.gyro_lines[i], file.units, laboratory_, rig,
                                               splitmix64(i == 0 ? seed + 1 : splitmix64(seed + 1) + i)));
  for (const auto& entry : file.thermometers) {
    sessions_.push_back(std::make_unique<simulator::Lakeshore218Session>(laboratory_, make_inputs(entry, laboratory_)));
    const auto& names = laboratory_.thermometer_names();
    auto& places = places_.emplace_back();
    for (const auto& channel : entry.channels)
      places.push_back(static_cast<std::size_t>(std::ranges::find(names, channel) - names.begin()));
    are_exchanged_.push_back(std::make_unique<bool>(false));
    thermometers_.push_back(std::make_unique<LineEnd>(
        rig, splitmix64(seed + 2 + sessions_.size()),
        [session = sessions_.back().get(), is_another = are_exchanged_.back().get()](auto sent, Bytes& answer) {
          (void)session->feed(sent, answer);
          if (*is_another) replace_serial_number(answer);
        },
        garble_text));
  }
  for (const auto& settings : file.supplies) add_supply(settings, file, rig, seed);
}

void Plant::add_supply(const rig::SupplySettings& settings, const rig::RigFile& file, const Clock& rig,
                       std::uint64_t seed) {
  simulator::VirtualSupplyOptions options{.description = settings.description, .outputs = {}};
  for (const auto& output : settings.outputs) {
    simulator::WiredOutput wired{.settings = output.settings, .units = {}};
    for (const auto& share : output.shares) wired.units.push_back(file.units[share.unit].info.name);
    options.outputs.push_back(std::move(wired));
  }
  auto& supply = supplies_.emplace_back(std::make_unique<simulator::VirtualSupply>(
      simulator::VirtualSupply::make(std::move(options), laboratory_).value()));
  supply->connect(laboratory_, supplies_.size() - 1);
  sessions_.push_back(make_supply_session(*supply, settings.description.unit.link));
  supply_lines_.push_back(std::make_unique<LineEnd>(
      rig, splitmix64(seed + 100 + supplies_.size()),
      [session = sessions_.back().get()](auto sent, Bytes& answer) { (void)session->feed(sent, answer); },
      garble_text));
}

void Plant::advance_second() {
  registers_.advance_second();
  laboratory_.step();
  for (auto& supply : supplies_) supply->advance_second();
  for (auto& gyro : gyros_) gyro->send_frame();
}

void Plant::restart_chamber(Celsius set_point, bool on) {
  laboratory_.change_set_point(set_point);
  laboratory_.switch_on(on);
}

void Plant::write(const char* item, double value) {
  const auto& found = *registers_.map().find(item);
  const auto words = encode(found, value);
  (void)registers_.write(drivers::WriteFunction::registers, found.address, words);
}

}  // namespace gyrotherm::faults
