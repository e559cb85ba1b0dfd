// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/new_rig/rig_probe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "core/clock.hpp"
#include "core/text.hpp"
#include "drivers/chamber/chamber_lock.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/pauses.hpp"
#include "sequencer/rig/inquiry.hpp"
#include "sequencer/rig/thermometer_settings.hpp"
#include "sequencer/run/chamber_ownership.hpp"

namespace gyrotherm::app {
namespace {

constexpr Duration kProbeWithin = std::chrono::milliseconds(1500);

/// Reads the registers of a chamber and refuses to write.
class ReadOnlyRegisters final : public drivers::Registers {
 public:
  explicit ReadOnlyRegisters(std::unique_ptr<drivers::Registers> registers) : registers_(std::move(registers)) {}
  Result<std::vector<std::uint16_t>> read(drivers::ReadFunction function, std::uint16_t address,
                                          std::uint16_t count) override {
    return registers_->read(function, address, count);
  }
  Result<void> write(drivers::WriteFunction, std::uint16_t, std::span<const std::uint16_t>) override {
    return failure(FaultKind::refused, "probe", "writes nothing");
  }
  void end_rest() override { registers_->end_rest(); }
  std::uint64_t breaks() const override { return registers_->breaks(); }

 private:
  std::unique_ptr<drivers::Registers> registers_;
};

std::unique_ptr<drivers::Registers> open_registers(const rig::RigFile& rig) {
  return std::make_unique<ReadOnlyRegisters>(
      drivers::make_registers(drivers::parse_line(rig.chamber_line).value(), rig.chamber_map));
}

Probe make_probe(std::string title, const Result<std::string>& answer) {
  const bool is_silent =
      !answer && (answer.error().kind == FaultKind::timeout || answer.error().kind == FaultKind::disconnected);
  return {.title = std::move(title),
          .answers = answer.has_value(),
          .text = plain(answer ? *answer : (is_silent ? "NO ANSWER: " : "NOT IDENTIFIED: ") + text(answer.error()))};
}

Probe probe_chamber(const rig::RigFile& rig, std::optional<Celsius>& air) {
  const SteadyClock watch;
  const auto chamber = drivers::make_modbus_chamber(rig.chamber_map, open_registers(rig), drivers::make_real_pauses());
  const auto answer = rig::query_chamber(*chamber, watch);
  auto probe = make_probe("chamber", answer);
  if (!answer) return probe;
  if (const auto state = chamber->inspect()) air = state->air;
  if (const auto order = rig::query_word_order(rig.chamber_map, *open_registers(rig)); order && !order->empty())
    probe.text += "; " + *order;
  return probe;
}

bool needs_configuration(const rig::ThermometerSettings& settings) {
  return settings.kind == drivers::ThermometerKind::mcc_usb_temp ||
         (settings.description && !settings.description->preparation.empty());
}

Probe probe_thermometer(const rig::ThermometerSettings& settings, std::string title, std::vector<Celsius>& readings) {
  const auto thermometer = rig::make_thermometer(settings, title, drivers::parse_line(settings.line).value());
  if (needs_configuration(settings)) {
    auto identity = thermometer->recognise();
    if (identity) *identity += "; not read, because it would be configured first";
    return make_probe(std::move(title), identity);
  }
  const SteadyClock watch;
  const auto answer = rig::query_thermometer(*thermometer, settings.channels, watch);
  if (answer) {
    const auto all = thermometer->read();
    for (std::size_t i = 0; i < settings.channels.size(); ++i)
      if (all[i]) readings.push_back(*all[i]);
  }
  return make_probe(std::move(title), answer);
}

Probe probe_gyro(const rig::RigFile& rig, rig::GyroLine line) {
  line.listen_only = true;
  const auto gyro = rig::make_gyro(line, drivers::parse_line(line.line).value(), kProbeWithin);
  const auto answer = rig::query_gyro(*gyro, line, rig.units, false, [] {});
  auto probe = make_probe(rig::line_title(line, rig.units), answer);
  if (!answer && line.stream && !line.stream->start.empty())
    probe.text += "; this gyro may need a start command, which the probe does not send: check --connect sends it";
  return probe;
}

}  // namespace

std::optional<drivers::WordOrder> find_other_word_order(const rig::RigFile& rig) {
  if (drivers::ChamberLock::holder(run::chamber_lock_name(rig))) return std::nullopt;
  const auto registers = open_registers(rig);
  const auto findings = rig::find_word_orders(rig.chamber_map, *registers);
  if (!findings || findings->empty() || findings->front().plausible) return std::nullopt;
  if (std::ranges::count(*findings, true, &drivers::OrderFinding::plausible) != 1) return std::nullopt;
  return std::ranges::find(*findings, true, &drivers::OrderFinding::plausible)->order;
}

std::vector<Probe> probe_instruments(const rig::RigFile& rig) {
  if (const auto holder = drivers::ChamberLock::holder(run::chamber_lock_name(rig)))
    return {{.title = "chamber", .answers = false, .text = "not contacted, the chamber is in use: " + holder->words}};
  std::optional<Celsius> air;
  std::vector<Probe> probes{probe_chamber(rig, air)};
  std::vector<Celsius> readings;
  for (std::size_t i = 0; i < rig.thermometers.size(); ++i)
    probes.push_back(probe_thermometer(rig.thermometers[i], fmt::format("thermometer {}", i + 1), readings));
  if (air)
    if (const auto warning = rig::describe_air_mismatch(*air, readings); !warning.empty())
      probes.front().text += "; " + warning;
  for (const auto& line : rig.gyro_lines) probes.push_back(probe_gyro(rig, line));
  return probes;
}

}  // namespace gyrotherm::app
