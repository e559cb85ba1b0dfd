// SPDX-License-Identifier: Apache-2.0
#include "sequencer/rig/rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <utility>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/shipped.hpp"
#include "core/text.hpp"
#include "drivers/chamber/modbus_chamber.hpp"
#include "drivers/chamber/text_registers.hpp"
#include "drivers/line/modbus.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/virtual_identity.hpp"
#include "sequencer/rig/inquiry.hpp"
#include "simulator/chamber_registers.hpp"
#include "simulator/laboratory_parameters.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "simulator/virtual_unit.hpp"

namespace gyrotherm::rig {
namespace {

/// Time limit for one read of a gyro in a run, shorter than the limit of InstrumentIo. A frame that arrives later stays
/// on the line for the next second's read.
constexpr Duration kGyroWithin = std::chrono::milliseconds(800);
constexpr Duration kGyroQueryWithin = std::chrono::milliseconds(1500);
/// Time limit for switching the supplies before a run.
constexpr Duration kSwitchingWithin = std::chrono::seconds(30), kTroubleWithin = std::chrono::seconds(5),
                   kPauseBetweenReads = std::chrono::milliseconds(200);
constexpr int kReadsOfVirtualSupply = 5;

/// Makes the drivers of a rig's instruments, each on its line.
class Drivers {
 public:
  virtual ~Drivers() = default;
  [[nodiscard]] virtual std::unique_ptr<drivers::Registers> registers(const drivers::RegisterMap& map) = 0;
  [[nodiscard]] virtual std::unique_ptr<drivers::Pauses> pauses() = 0;
  [[nodiscard]] virtual std::unique_ptr<drivers::Thermometer> thermometer(const RigFile& file, std::size_t index,
                                                                          const std::string& place) = 0;
  [[nodiscard]] virtual std::unique_ptr<drivers::Gyro> gyro(const RigFile& file, std::size_t line, Duration within) = 0;
  [[nodiscard]] virtual std::unique_ptr<drivers::AnalogueInputs> analogue(const RigFile& file, std::size_t index) = 0;
  [[nodiscard]] virtual std::unique_ptr<drivers::PowerSupply> supply(const RigFile& file, std::size_t index) = 0;
};

/// Makes the drivers of a real rig. The file's lines were checked when it was read.
class DriversOnLines final : public Drivers {
 public:
  explicit DriversOnLines(const std::string& chamber) : chamber_(drivers::parse_line(chamber).value()) {}

  std::unique_ptr<drivers::Registers> registers(const drivers::RegisterMap& map) override {
    return make_registers(chamber_, map);
  }
  std::unique_ptr<drivers::Pauses> pauses() override { return drivers::make_real_pauses(); }
  std::unique_ptr<drivers::Thermometer> thermometer(const RigFile& file, std::size_t index,
                                                    const std::string& place) override {
    const auto& settings = file.thermometers[index];
    if (settings.kind == drivers::ThermometerKind::process) return make_process_thermometer(settings, place);
    return make_thermometer(settings, place, drivers::parse_line(settings.line).value());
  }
  std::unique_ptr<drivers::Gyro> gyro(const RigFile& file, std::size_t line, Duration within) override {
    const auto& settings = file.gyro_lines[line];
    return make_gyro(settings, drivers::parse_line(settings.line).value(), within);
  }
  std::unique_ptr<drivers::AnalogueInputs> analogue(const RigFile& file, std::size_t index) override {
    const auto& settings = file.analogue_inputs[index];
    auto registers = make_modbus(drivers::parse_line(settings.line).value(), settings.map.registers.link.modbus);
    return make_analogue_inputs(settings, analogue_title(index), std::move(registers), drivers::make_real_pauses());
  }

  std::unique_ptr<drivers::PowerSupply> supply(const RigFile& file, std::size_t index) override {
    const auto& settings = file.supplies[index];
    return make_supply(settings, supply_title(index), drivers::parse_line(settings.line).value());
  }

 private:
  drivers::Line chamber_;
};

class DriversOnWires final : public Drivers {
 public:
  explicit DriversOnWires(Wires& wires) : wires_(wires) {}

  std::unique_ptr<drivers::Registers> registers(const drivers::RegisterMap& map) override {
    return wires_.chamber(map);
  }
  std::unique_ptr<drivers::Pauses> pauses() override { return wires_.pauses(); }
  std::unique_ptr<drivers::Thermometer> thermometer(const RigFile& file, std::size_t index,
                                                    const std::string& place) override {
    const auto& settings = file.thermometers[index];
    if (settings.kind == drivers::ThermometerKind::mcc_usb_temp) {
      auto wire = wires_.usb_temp(index);
      return make_usb_temp(settings, place, std::move(wire.line), wire.clock);
    }
    auto wire = wires_.thermometer(index);
    return make_thermometer(settings, place, std::move(wire.line), true, wire.clock);
  }
  std::unique_ptr<drivers::Gyro> gyro(const RigFile& file, std::size_t line, Duration within) override {
    auto wire = wires_.gyro(line);
    return make_simulated_gyro(file.gyro_lines[line], std::move(wire.line), within, wire.clock);
  }
  std::unique_ptr<drivers::AnalogueInputs> analogue(const RigFile& file, std::size_t index) override {
    auto settings = file.analogue_inputs[index];
    auto& link = settings.map.registers.link.modbus;
    link = remove_pauses(std::move(link));
    auto wire = wires_.analogue_input(index, settings.map.registers);
    return make_analogue_inputs(settings, analogue_title(index), std::move(wire.line), wires_.pauses());
  }

  std::unique_ptr<drivers::PowerSupply> supply(const RigFile& file, std::size_t index) override {
    auto wire = wires_.supply(index);
    return make_supply(file.supplies[index], supply_title(index), std::move(wire.line), wire.clock);
  }

 private:
  Wires& wires_;
};

/// Repeats a query after any failure except `refused`, because one lost answer must not prevent a run. Returns the
/// first failure if all attempts fail.
template <typename Ask>
auto query_with_retries(const Ask& ask) {
  constexpr int kMaxTries = 3;
  auto answer = ask();
  for (int tries = 1; !answer && answer.error().kind != FaultKind::refused && tries < kMaxTries; ++tries)
    if (auto again = ask(); again) answer = std::move(again);
  return answer;
}

std::vector<bool> find_optional_lines(const RigFile& file, const RigStart& start) {
  const auto is_dropped = [&](const GyroLine::Share& share) {
    return std::ranges::count(start.dropped_units, file.units[share.unit].info.name) > 0;
  };
  std::vector<bool> may_be_off;
  for (const auto& line : file.gyro_lines)
    may_be_off.push_back(start.units_may_be_off || std::ranges::all_of(line.shares, is_dropped));
  return may_be_off;
}

std::string thermometer_title(std::size_t index) { return fmt::format("thermometer {}", index + 1); }

/// Returns what to check when an instrument of a new rig does not answer, or gives another answer than expected.
/// `chamber` is null for any other instrument.
std::string suggest_remedy(FaultKind kind, const drivers::RegisterMap* chamber) {
  switch (kind) {
    case FaultKind::timeout:
    case FaultKind::disconnected:
      return "check its power, cable, line and settings, and that no other program or instrument uses this line";
    case FaultKind::refused:
    case FaultKind::corrupted:
    case FaultKind::out_of_range:
      if (chamber == nullptr) return "";
      return chamber->text_link ? "check that the description fits the instrument; \"gyrotherm describe --talk\" shows "
                                  "its answers"
                                : "check that the map fits the controller and its data map, and the unit number";
    default: return {};
  }
}

/// Returns the place of an instrument: "on tcp://10.0.0.5:502".
std::string on_line(const auto& settings) { return "on " + settings.line; }

std::string describe_line(const GyroLine& line) {
  return line.stream ? fmt::format("stream {} on {}", line.stream->name, line.line) : on_line(line);
}

/// Instruments on their lines, and the InstrumentIo that reads them.
class AssembledRig : public Rig {
 public:
  AssembledRig(RigFile file, std::unique_ptr<Drivers> drivers, const RigStart& start)
      : file_(std::move(file)),
        drivers_(std::move(drivers)),
        may_be_off_(find_optional_lines(file_, start)),
        power_(start.power) {
    auto& map = file_.chamber_map;
    if (file_.simulated) map.link.modbus = remove_pauses(std::move(map.link.modbus));
    chamber_ = make_modbus_chamber(map, record_activity(drivers_->registers(map), chamber_line_),
                                   record_activity(drivers_->pauses(), chamber_line_));
    for (std::size_t i = 0; i < file_.thermometers.size(); ++i)
      thermometers_.push_back(drivers_->thermometer(file_, i, thermometer_title(i)));
    for (std::size_t i = 0; i < file_.analogue_inputs.size(); ++i) analogue_.push_back(drivers_->analogue(file_, i));
    for (std::size_t i = 0; i < file_.supplies.size(); ++i) supplies_.push_back(drivers_->supply(file_, i));
  }

  std::vector<Result<std::string>> query_instruments() override {
    const SteadyClock watch;
    const auto titled = [this](const std::string& title, const std::string& place, const Result<std::string>& answer) {
      if (!answer) return Result<std::string>(failure(explain(title, place, answer.error())));
      const bool is_marked = is_unexpectedly_virtual(*answer);
      return Result<std::string>(plain(title + ": " + *answer + (is_marked ? "; SIMULATED: it is virtual" : "")));
    };
    std::vector<Result<std::string>> answers{titled(kChamberTitle, chamber_place(), query_chamber(watch))};
    for (std::size_t i = 0; i < thermometers_.size(); ++i)
      answers.push_back(titled(thermometer_title(i), on_line(file_.thermometers[i]),
                               query_thermometer(*thermometers_[i], file_.thermometers[i].channels, watch)));
    if (answers.front())
      if (const auto warning = compare_air(); !warning.empty()) *answers.front() += "; " + warning;
    const auto unpowered = find_unpowered_units();
    for (std::size_t i = 0; i < file_.gyro_lines.size(); ++i) {
      const GyroLine& line = file_.gyro_lines[i];
      const auto gyro = drivers_->gyro(file_, i, kGyroQueryWithin);
      const bool is_off =
          std::ranges::all_of(line.shares, [&](const auto& share) { return unpowered.contains(share.unit); });
      answers.push_back(titled(line_title(line, file_.units), describe_line(line),
                               is_off
                                   ? Result<std::string>("not read, because the output of its supply is off; a run "
                                                         "switches it on")
                                   : query_gyro(*gyro, line, file_.units, file_.simulated, [this] { let_pass(1); })));
    }
    for (std::size_t i = 0; i < analogue_.size(); ++i)
      answers.push_back(titled(analogue_title(i), on_line(file_.analogue_inputs[i]),
                               query_analogue(*analogue_[i], analogue_readings(i), watch)));
    for (std::size_t i = 0; i < supplies_.size(); ++i)
      answers.push_back(
          titled(supply_title(i), on_line(file_.supplies[i]), query_supply(*supplies_[i], file_.supplies[i], watch)));
    return answers;
  }

  using Rig::prepare;
  Result<std::vector<std::string>> prepare(const Entrance& entrance, const drivers::ChamberProgram* program) override {
    auto prepared = establish_power().and_then([&] { return prepare_powered(entrance, program); });
    if (!prepared) restore_power();
    return prepared;
  }
  bool is_as_found() const override { return is_as_found_; }
  Result<drivers::SetPointRange> controller_limits() override { return chamber_->limits(); }

  io::InstrumentIo& io() override { return *io_; }
  const RigFile& file() const override { return file_; }

 protected:
  /// Returns the units whose supplies answer and have switched all of their outputs off.
  [[nodiscard]] std::set<std::size_t> find_unpowered_units() {
    std::set<std::size_t> off, on;
    for (std::size_t i = 0; i < supplies_.size(); ++i) {
      if (!supplies_[i]->identify()) continue;
      const auto outputs = supplies_[i]->inspect();
      for (std::size_t j = 0; j < outputs.size(); ++j)
        for (const auto& share : file_.supplies[i].outputs[j].shares)
          if (outputs[j]) (outputs[j]->state.is_on ? on : off).insert(share.unit);
    }
    for (const auto unit : on) off.erase(unit);
    return off;
  }

  [[nodiscard]] io::Instruments instruments() {
    io::Instruments all{.chamber = *chamber_, .thermometers = {}, .gyros = {}, .chamber_line = chamber_line_.get()};
    all.chamber_known = known(kChamberTitle);
    for (std::size_t i = 0; i < thermometers_.size(); ++i)
      all.thermometers.push_back({*thermometers_[i], file_.thermometers[i].channels, known(thermometer_title(i))});
    for (std::size_t i = 0; i < gyros_.size(); ++i) {
      io::GyroInputs inputs{*gyros_[i], {}, known(line_title(file_.gyro_lines[i], file_.units))};
      for (const auto& [unit, axes, values] : file_.gyro_lines[i].shares) inputs.shares.push_back({unit, axes, values});
      all.gyros.push_back(std::move(inputs));
    }
    for (std::size_t i = 0; i < analogue_.size(); ++i) {
      io::AnalogueChannels inputs{*analogue_[i], {}, known(analogue_title(i))};
      for (const auto& channel : file_.analogue_inputs[i].channels)
        inputs.channels.push_back({.unit = channel.unit,
                                   .value = channel.value,
                                   .name = file_.units[channel.unit].info.name + "." + channel.name,
                                   .scale = channel.scale,
                                   .offset = channel.offset});
      all.analogue.push_back(std::move(inputs));
    }
    for (std::size_t i = 0; i < supplies_.size(); ++i) {
      io::SupplyChannels inputs{*supplies_[i], {}, known(supply_title(i))};
      for (const auto& output : file_.supplies[i].outputs) {
        inputs.outputs.emplace_back();
        for (const auto& [unit, voltage, current] : output.shares)
          inputs.outputs.back().push_back(
              {.unit = unit, .voltage = voltage, .current = current, .name = output_title(i, output)});
      }
      all.supplies.push_back(std::move(inputs));
    }
    return all;
  }
  void end_sampling() { io_.reset(); }

 private:
  /// Names in a fault the instrument, its place, and what to check.
  [[nodiscard]] Fault explain(const std::string& title, const std::string& place, Fault fault) const {
    fault = name_instrument(title, std::move(fault));
    fault.what += " (" + place + ")";
    const auto remedy = suggest_remedy(fault.kind, title == kChamberTitle ? &file_.chamber_map : nullptr);
    if (!remedy.empty()) fault.what += "; " + remedy;
    return fault;
  }
  [[nodiscard]] std::string chamber_place() const {
    return fmt::format("{} on {}", file_.chamber_map.name, file_.chamber_line);
  }
  [[nodiscard]] Fault explain_chamber(Fault fault) const {
    return explain(kChamberTitle, chamber_place(), std::move(fault));
  }
  [[nodiscard]] Fault explain_supply(std::size_t index, Fault fault) const {
    return explain(supply_title(index), on_line(file_.supplies[index]), std::move(fault));
  }
  [[nodiscard]] Fault explain_gyro(std::size_t line, Fault fault) const {
    const auto& settings = file_.gyro_lines[line];
    return explain(line_title(settings, file_.units), describe_line(settings), std::move(fault));
  }

  /// Makes the InstrumentIo for the rig's kind of time, and starts its clock.
  [[nodiscard]] virtual std::unique_ptr<io::InstrumentIo> make_io() = 0;

  /// Prepares the other instruments when the units have power.
  Result<std::vector<std::string>> prepare_powered(const Entrance& entrance, const drivers::ChamberProgram* program) {
    if (auto opened = open_gyros(); !opened) return failure(opened.error());
    auto names = query_identities();
    if (!names) return names;
    const auto found = inspect_chamber();
    if (!found) return failure(found.error());
    const auto first = entrance(*found);
    if (!first) return failure(first.error());
    is_as_found_ = false;
    const auto kept = start_chamber(*first, program);
    if (!kept) {
      is_as_found_ = restore_chamber(found->state, program != nullptr);
      return failure(kept.error());
    }
    if (program) names->push_back(*kept);
    io_ = make_io();
    return names;
  }

  /// Identifies the supplies, records whether each was on, applies the demand and waits until each switch is verified.
  /// Permits the units of a supply that remains off to be silent. Fails at the first supply that fails.
  Result<void> establish_power() {
    for (std::size_t i = 0; i < supplies_.size(); ++i) {
      auto& supply = *supplies_[i];
      if (const auto known = query_with_retries([&] { return supply.identify(); }); !known)
        return failure(explain_supply(i, known.error()));
      const auto before = read_supply(i);
      if (!before) return failure(explain_supply(i, before.error()));
      found_power_.push_back(*before);
      if (power_ != drivers::PowerDemand::keep) supply.demand(power_);
      if (auto done = finish_demand(i); !done) return done;
      const auto after = read_supply(i);
      if (!after) return failure(explain_supply(i, after.error()));
      if (!after->all_on) permit_silence(i);
    }
    powered_at_ = watch_.now().since_start;
    return {};
  }

  /// State of the outputs of a supply.
  struct OutputPower {
    bool all_on{}, any_on{};
  };
  Result<OutputPower> read_supply(std::size_t index) {
    drivers::SupplyReadings readings;
    const auto read = query_with_retries([&]() -> Result<void> {
      readings = supplies_[index]->read();
      for (const auto& output : readings.outputs)
        if (!output) return failure(output.error());
      return {};
    });
    if (!read) return failure(read.error());
    const auto is_on = [](const auto& output) { return output->is_on; };
    return OutputPower{.all_on = std::ranges::all_of(readings.outputs, is_on),
                       .any_on = std::ranges::any_of(readings.outputs, is_on)};
  }

  /// Reads a supply until its demand is verified. Fails when a trouble lasts, or after a trip.
  Result<void> finish_demand(std::size_t index) {
    const Deadline end(kSwitchingWithin);
    std::optional<Deadline> trouble_end;
    auto readings = supplies_[index]->read();
    for (int reads = 1; readings.pending != drivers::PowerDemand::keep; ++reads) {
      if (readings.trouble.empty()) trouble_end.reset();
      if (!readings.trouble.empty() && !trouble_end) trouble_end.emplace(kTroubleWithin);
      const bool is_late = file_.simulated ? reads >= kReadsOfVirtualSupply
                                           : end.has_passed() || (trouble_end && trouble_end->has_passed());
      if (is_late || readings.gave_up)
        return failure(FaultKind::mismatch, supply_title(index),
                       readings.trouble.empty() ? "the outputs are not switched in time" : readings.trouble);
      drivers_->pauses()->rest(kPauseBetweenReads);
      readings = supplies_[index]->read();
    }
    return {};
  }

  /// Returns true if a supply feeds a unit on a gyro line.
  [[nodiscard]] bool feeds(const SupplySettings& supply, const GyroLine& line) const {
    return std::ranges::any_of(supply.outputs, [&](const SupplyOutput& output) {
      return std::ranges::any_of(output.shares, [&](const SupplyOutput::Share& fed) {
        return std::ranges::count(line.shares, fed.unit, &GyroLine::Share::unit) > 0;
      });
    });
  }

  /// Returns how much longer the units on a gyro line may boot: zero if they had power before the preparation, and on a
  /// virtual rig.
  [[nodiscard]] Duration boot_time_left(const GyroLine& line) const {
    Duration longest{};
    for (std::size_t i = 0; i < found_power_.size() && !file_.simulated; ++i)
      if (!found_power_[i].all_on && feeds(file_.supplies[i], line))
        longest = std::max(longest, file_.supplies[i].boot);
    return std::max(Duration{}, longest - (watch_.now().since_start - powered_at_));
  }

  /// Repeats a query of a gyro until it succeeds. Returns the last failure when the units on its line must have booted.
  template <typename Ask>
  auto query_booting_gyro(std::size_t index, const Ask& ask) {
    auto answer = query_with_retries(ask);
    if (may_be_off_[index]) return answer;
    const Deadline booted(boot_time_left(file_.gyro_lines[index]));
    while (!answer && !booted.has_passed()) {
      drivers_->pauses()->rest(kPauseBetweenReads);
      answer = ask();
    }
    return answer;
  }

  /// Permits the units of a supply that is off to be silent.
  void permit_silence(std::size_t index) {
    for (std::size_t line = 0; line < file_.gyro_lines.size(); ++line)
      if (feeds(file_.supplies[index], file_.gyro_lines[line])) may_be_off_[line] = true;
  }

  /// Switches the supplies that had no output on back off, after a failed preparation.
  void restore_power() {
    for (std::size_t i = 0; i < found_power_.size(); ++i) {
      if (found_power_[i].any_on || power_ != drivers::PowerDemand::on) continue;
      supplies_[i]->demand(drivers::PowerDemand::off);
      (void)finish_demand(i);
    }
  }

  /// Queries the word order first, on a separate connection that is closed again: some chambers accept one client at a
  /// time.
  Result<std::string> query_chamber(const Clock& watch) {
    const auto order = query_word_order(file_.chamber_map, *drivers_->registers(file_.chamber_map));
    if (!order) return order;
    auto answer = gyrotherm::rig::query_chamber(*chamber_, watch);
    if (answer && !order->empty()) *answer += "; " + *order;
    return answer;
  }

  /// Warns if the chamber's air is far from all readings of the thermometers.
  [[nodiscard]] std::string compare_air() {
    const auto state = chamber_->read();
    return state ? compare_air(state->air) : std::string();
  }
  [[nodiscard]] std::string compare_air(Celsius air) {
    std::vector<Celsius> read;
    for (const auto& thermometer : thermometers_)
      for (const auto& one : thermometer->read())
        if (one) read.push_back(*one);
    return describe_air_mismatch(air, read);
  }

  /// Returns the conversions of one instrument with analogue inputs, for the description of its readings.
  [[nodiscard]] std::vector<AnalogueReading> analogue_readings(std::size_t index) const {
    const auto& settings = file_.analogue_inputs[index];
    std::vector<AnalogueReading> readings;
    for (const auto& channel : settings.channels) {
      const auto& unit = file_.units[channel.unit];
      const auto value = unit.info.values.size() - unit.analogue_values + channel.value;
      readings.push_back({.channel = unit.info.name + "." + channel.name,
                          .unit = unit.info.values[value].unit,
                          .scale = channel.scale,
                          .offset = channel.offset});
    }
    return readings;
  }

  /// Returns whether an instrument of a real rig has the identity of a virtual one.
  [[nodiscard]] bool is_unexpectedly_virtual(const std::string& identity) const {
    return !file_.simulated && drivers::is_virtual_identity(identity);
  }

  /// Returns the titles of the instruments whose identity is that of a virtual one; none on a virtual rig.
  [[nodiscard]] std::vector<std::string> list_virtual_instruments() const {
    std::vector<std::string> titles;
    for (const auto& [title, identity] : identities_)
      if (is_unexpectedly_virtual(identity)) titles.push_back(title);
    return titles;
  }

  Result<FoundChamber> inspect_chamber() {
    const auto state = query_with_retries([&] { return chamber_->inspect(); });
    if (!state) return failure(explain_chamber(state.error()));
    const auto limits = query_with_retries([&] { return chamber_->limits(); });
    if (!limits) return failure(explain_chamber(limits.error()));
    return FoundChamber{.state = *state,
                        .limits = *limits,
                        .missing = chamber_->missing(),
                        .identities = identities_,
                        .virtual_instruments = list_virtual_instruments(),
                        .settings = chamber_->settings(),
                        .air_mismatch = file_.simulated ? std::string() : compare_air(state->air)};
  }

  /// Sends the chamber to its first set point, and starts it unless it refused that set point. Returns the chamber's
  /// description of the stored program.
  Result<std::string> start_chamber(Celsius first, const drivers::ChamberProgram* program) {
    const auto moved = chamber_->send_set_point(first).and_then([&] { return chamber_->start(); });
    if (!moved) return failure(name_instrument(kChamberTitle, moved.error()));
    auto kept = program ? chamber_->upload(*program) : Result<std::string>();
    if (!kept) return failure(name_instrument(kChamberTitle, kept.error()));
    let_pass(1);
    // The first frame may arrive only after a whole period, which is longer than one read waits.
    for (std::size_t i = 0; i < gyros_.size(); ++i) {
      const auto origin = query_booting_gyro(i, [&] { return gyros_[i]->wait_for_origin(); });
      if (!origin && !may_be_off_[i]) return failure(explain_gyro(i, origin.error()));
    }
    if (const auto started = program ? chamber_->start_program() : Result<void>(); !started)
      return failure(name_instrument(kChamberTitle, started.error()));
    return kept;
  }

  /// Returns the chamber to its state as found. Returns true if the chamber acknowledged every step. Returns false if
  /// the chamber was running at a set point that cannot be read.
  bool restore_chamber(const ChamberState& found, bool may_run_program) {
    chamber_->end_rest();
    bool done = !may_run_program || chamber_->end_program();
    const bool was_off = found.activity == ChamberActivity::off, is_known = !std::isnan(found.set_point.value);
    if (is_known) done = chamber_->send_set_point_immediately(found.set_point) && done;
    if (was_off) done = chamber_->stop() && done;
    return done && (is_known || was_off);
  }

  Result<void> open_gyros() {
    for (std::size_t i = 0; i < file_.gyro_lines.size(); ++i) gyros_.push_back(drivers_->gyro(file_, i, kGyroWithin));
    for (std::size_t i = 0; i < gyros_.size(); ++i)
      if (auto open = query_booting_gyro(i, [&] { return gyros_[i]->open(); }); !open && !may_be_off_[i])
        return failure(explain_gyro(i, open.error()));
    return {};
  }

  /// An instrument whose identity is queried. A gyro that may be switched off need not answer.
  struct IdentifiedInstrument {
    std::string title, place;
    drivers::Identified& instrument;
    /// Index of the gyro line; none for other instruments.
    std::optional<std::size_t> gyro_line{};
  };
  /// Returns the identity of an instrument. A gyro that was switched on is asked again while it boots, because it does
  /// not answer until then, and one that never answered has an empty identity.
  Result<std::string> query_identity(const IdentifiedInstrument& one) {
    if (!one.gyro_line) return query_with_retries([&] { return one.instrument.identify(); });
    const auto& line = file_.gyro_lines[*one.gyro_line];
    const bool must_answer = line.stream && line.stream->identity && !line.listen_only;
    bool is_empty = false;
    const auto answer = query_booting_gyro(*one.gyro_line, [&]() -> Result<std::string> {
      auto identity = one.instrument.identify();
      is_empty = identity && identity->empty() && must_answer;
      if (is_empty) return failure(FaultKind::timeout, one.title, "it does not answer the query for its identity");
      return identity;
    });
    return is_empty ? std::string() : answer;
  }
  [[nodiscard]] std::vector<IdentifiedInstrument> identified_instruments() {
    std::vector<IdentifiedInstrument> all{{kChamberTitle, chamber_place(), *chamber_}};
    for (std::size_t i = 0; i < thermometers_.size(); ++i)
      all.push_back({thermometer_title(i), on_line(file_.thermometers[i]), *thermometers_[i]});
    for (std::size_t i = 0; i < analogue_.size(); ++i)
      all.push_back({analogue_title(i), on_line(file_.analogue_inputs[i]), *analogue_[i]});
    for (std::size_t i = 0; i < supplies_.size(); ++i)
      all.push_back({supply_title(i), on_line(file_.supplies[i]), *supplies_[i]});
    for (std::size_t i = 0; i < gyros_.size(); ++i) {
      const auto& line = file_.gyro_lines[i];
      all.push_back({line_title(line, file_.units), describe_line(line), *gyros_[i], i});
    }
    return all;
  }

  Result<std::vector<std::string>> query_identities() {
    std::vector<std::string> names;
    for (const auto& one : identified_instruments()) {
      const auto answer = query_identity(one);
      const bool may_be_off = one.gyro_line && may_be_off_[*one.gyro_line];
      if (!answer && !may_be_off) return failure(explain(one.title, one.place, answer.error()));
      if (!answer || answer->empty()) continue;
      if (one.gyro_line)
        if (auto same = compare_serial_number(file_.gyro_lines[*one.gyro_line], file_.units, *answer); !same)
          return failure(same.error());
      identities_.emplace(one.title, *answer);
      names.push_back(plain(*answer));
    }
    return names;
  }

  [[nodiscard]] io::KnownIdentity known(const std::string& title) const {
    const auto found = identities_.find(title);
    return {title, found == identities_.end() ? "" : found->second};
  }

  RigFile file_;
  std::unique_ptr<Drivers> drivers_;
  std::shared_ptr<drivers::LineActivity> chamber_line_ = std::make_shared<drivers::LineActivity>();
  std::unique_ptr<drivers::Chamber> chamber_;
  std::vector<std::unique_ptr<drivers::Thermometer>> thermometers_;
  std::vector<std::unique_ptr<drivers::AnalogueInputs>> analogue_;
  std::vector<std::unique_ptr<drivers::PowerSupply>> supplies_;
  std::vector<std::unique_ptr<drivers::Gyro>> gyros_;  ///< one per gyro line
  /// Lines that may be silent at the start.
  std::vector<bool> may_be_off_;
  drivers::PowerDemand power_;
  /// State of each supply before its demand.
  std::vector<OutputPower> found_power_;
  SteadyClock watch_;
  /// Time at which the demands of all supplies were verified, on `watch_`.
  Duration powered_at_{};
  std::map<std::string, std::string> identities_;  ///< key: title
  bool is_as_found_ = true;
  // Last member: it stops before its instruments are destroyed.
  std::unique_ptr<io::InstrumentIo> io_;
};

class RealRig final : public AssembledRig {
 public:
  RealRig(const RigFile& file, const RigStart& start)
      : AssembledRig(file, std::make_unique<DriversOnLines>(file.chamber_line), start),
        elapsed_(start.elapsed),
        clock_(start.elapsed) {}
  // The workers read the clock, which is destroyed before the base class.
  ~RealRig() override { end_sampling(); }
  void let_pass(std::int64_t) override {}
  void set_unit_state(const UnitState&) override {}
  const Clock& clock() const override { return clock_; }
  Duration will_start_utc() const override { return clock_.now().utc; }

 private:
  std::unique_ptr<io::InstrumentIo> make_io() override {
    if (elapsed_ == Duration{}) clock_ = SteadyClock();
    return io::InstrumentIo::workers(instruments());
  }
  Duration elapsed_;
  SteadyClock clock_;
};

/// The rig's own wires. They are a base class, so they are made before the instruments and destroyed after them.
struct OwnedWires {
  std::unique_ptr<Wires> owned_;
};

class VirtualRig final : private OwnedWires, public AssembledRig {
 public:
  VirtualRig(const RigFile& file, Wires& wires)
      : AssembledRig(file, std::make_unique<DriversOnWires>(wires), {}), wires_(wires) {}
  VirtualRig(const RigFile& file, std::unique_ptr<Wires> wires, const RigStart& start)
      : OwnedWires{std::move(wires)},
        AssembledRig(file, std::make_unique<DriversOnWires>(*owned_), start),
        wires_(*owned_) {}

  void let_pass(std::int64_t seconds) override { wires_.let_pass(seconds); }
  void set_unit_state(const UnitState& state) override { wires_.set_unit_state(state); }
  const Clock& clock() const override { return wires_.clock(); }
  Duration will_start_utc() const override { return wires_.clock().now().utc + kSecond; }

 private:
  std::unique_ptr<io::InstrumentIo> make_io() override {
    auto all = instruments();
    all.true_bias = [this](std::size_t unit) { return wires_.true_bias(file().units[unit].info.name); };
    return io::InstrumentIo::inline_calls(std::move(all));
  }
  Wires& wires_;
};

simulator::VirtualThermometer virtual_thermometer(const ThermometerSettings& settings) {
  simulator::VirtualThermometer thermometer{.channels = settings.channels,
                                            .kind = settings.kind,
                                            .addresses = settings.addresses,
                                            .checksum = settings.checksum,
                                            .description = settings.description};
  if (settings.type) thermometer.type = *settings.type;
  return thermometer;
}

simulator::VirtualGyroLine virtual_gyro(const GyroLine& line, const std::vector<UnitSettings>& units) {
  simulator::VirtualGyroLine served{.frame = line.frame};
  if (line.stream) served.commands = line.stream->start;
  if (line.stream) served.identity = line.stream->identity;
  for (const auto& share : line.shares)
    for (const auto& axis : units[share.unit].info.axes)
      served.axes.push_back({.unit = units[share.unit].info.name, .axis = axis.name});
  return served;
}

simulator::VirtualAnalogueInput virtual_analogue(const AnalogueSettings& settings,
                                                 const std::vector<UnitSettings>& units) {
  simulator::VirtualAnalogueInput served{.map = settings.map, .inputs = {}};
  for (const auto& channel : settings.channels)
    served.inputs.push_back({.input = channel.input,
                             .unit = units[channel.unit].info.name,
                             .value = channel.name,
                             .scale = channel.scale,
                             .offset = channel.offset});
  return served;
}

/// Returns the virtual supply. The only unit of a real rig is the only one of the laboratory.
simulator::VirtualSupplyOptions virtual_supply(const SupplySettings& settings, const RigFile& file) {
  simulator::VirtualSupplyOptions served{.description = settings.description, .outputs = {}};
  for (const auto& output : settings.outputs) {
    simulator::WiredOutput wired{.settings = output.settings, .units = {}};
    for (const auto& share : output.shares)
      wired.units.push_back(file.simulated ? file.units[share.unit].info.name : std::string(simulator::kPlainUnit));
    served.outputs.push_back(std::move(wired));
  }
  return served;
}

/// Returns the world of the rig; for a real rig, the world of the shipped virtual rig.
Result<simulator::LaboratoryParameters> laboratory_for(const RigFile& file) {
  if (file.simulated) return simulator::parse_laboratory(file.text, file.file, file.gyro_model.text);
  if (file.units.size() != 1 || file.units.front().info.axes.size() != 1)
    return failure(FaultKind::usage, file.file,
                   "a real rig with several axes cannot be served, because their signals are unknown");
  const auto path = resolve_path("virtual", kShippedRig);
  if (!path) return failure(path.error());
  const auto text = read_text_file(*path);
  if (!text) return failure(text.error());
  auto laboratory = simulator::parse_laboratory(*text, *path, {});
  const auto& axis = file.units.front().info.axes.front();
  if (laboratory && axis.earth_rate) laboratory->gyro.earth_rate_deg_per_h = axis.earth_rate->value;
  return laboratory;
}

/// Assigns the channels of the virtual laboratory to the thermometers in order, regardless of the channels' names. With
/// more thermometers than channels, several thermometers measure at the same place.
void assign_virtual_channels(const std::vector<std::string>& there,
                             std::vector<simulator::VirtualThermometer>& thermometers) {
  std::size_t next = 0;
  for (auto& thermometer : thermometers)
    for (auto& channel : thermometer.channels) channel = there[next++ % there.size()];
}

}  // namespace

Result<std::unique_ptr<simulator::VirtualInstruments>> serve_virtual(const RigFile& file,
                                                                     simulator::LaboratorySeed seed,
                                                                     const ServeOptions& how) {
  const auto unit = simulator::read_simulated_unit(file.chamber_map, file.chamber_map.name);
  if (!unit) return failure(unit.error());
  if (auto sound = check_simulated_identity(file.chamber_map, *unit, file.chamber_map.name); !sound)
    return failure(std::move(sound.error()));
  auto parameters = laboratory_for(file);
  if (!parameters) return failure(parameters.error());
  if (parameters->soaked && how.first_set_point)
    parameters = simulator::soak_at(std::move(*parameters), *how.first_set_point);
  simulator::VirtualInstrumentsOptions options{.chamber = file.chamber_map,
                                               .thermometers = {},
                                               .gyros = {},
                                               .first_port = how.first_port,
                                               .frames = how.frames,
                                               .ptys = how.ptys,
                                               .attended = how.attended};
  for (const auto& line : file.gyro_lines) options.gyros.push_back(virtual_gyro(line, file.units));
  for (const auto& settings : file.thermometers) options.thermometers.push_back(virtual_thermometer(settings));
  if (!file.simulated)
    assign_virtual_channels(simulator::list_thermometer_names(parameters->units), options.thermometers);
  for (const auto& settings : file.analogue_inputs)
    options.analogue_inputs.push_back(virtual_analogue(settings, file.units));
  for (const auto& settings : file.supplies) options.supplies.push_back(virtual_supply(settings, file));
  options.relay = file.safe_also;
  return simulator::VirtualInstruments::start(simulator::VirtualLaboratory(*parameters, seed), std::move(options));
}

Result<std::unique_ptr<Rig>> Rig::assemble(const RigFile& file, const RigStart& start) {
  if (!file.simulated) return std::make_unique<RealRig>(file, start);
  auto laboratory = serve_virtual(file, start.seed, {.first_set_point = start.first_set_point, .attended = true});
  if (!laboratory) return failure(laboratory.error());
  (*laboratory)->replay(start.replay);
  const auto later = std::chrono::days(start.seed.days_later);
  return std::make_unique<VirtualRig>(file, make_attended_wires(std::move(*laboratory), start.elapsed, later), start);
}

std::unique_ptr<Rig> Rig::assemble(const RigFile& file, Wires& wires) {
  assert(file.simulated);
  return std::make_unique<VirtualRig>(file, wires);
}

}  // namespace gyrotherm::rig
