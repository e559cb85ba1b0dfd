// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_instruments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "core/tcp_listener.hpp"
#include "simulator/chamber_registers.hpp"
#include "simulator/identity_marks.hpp"
#include "simulator/servers/modbus_server.hpp"
#include "simulator/servers/reply_server.hpp"
#include "simulator/servers/scanner_server.hpp"
#include "simulator/servers/supply_server.hpp"
#include "simulator/servers/text_server.hpp"
#include "simulator/servers/virtual_thermometers.hpp"
#include "simulator/virtual_relay.hpp"

namespace gyrotherm::simulator {
namespace {

/// Indices of the laboratory's thermometers, in the order of an instrument's inputs.
using ThermometerIndices = std::vector<std::size_t>;

std::size_t input_count(const VirtualThermometer& thermometer) {
  if (thermometer.description) return thermometer.description->inputs;
  const auto modules = thermometer.kind == drivers::ThermometerKind::dcon ? thermometer.addresses.size() : 1;
  return kind_row(thermometer.kind).inputs * modules;
}

Result<ThermometerIndices> find_thermometers(const VirtualThermometer& thermometer,
                                             const VirtualLaboratory& laboratory) {
  if (thermometer.channels.size() > input_count(thermometer))
    return failure(
        FaultKind::bad_file, "virtual thermometer",
        fmt::format("{} channels, expected at most {}", thermometer.channels.size(), input_count(thermometer)));
  const auto& names = laboratory.thermometer_names();
  ThermometerIndices indices;
  for (const auto& channel : thermometer.channels) {
    const auto found = std::ranges::find(names, channel);
    if (found == names.end())
      return failure(FaultKind::bad_file, "virtual thermometer",
                     fmt::format("channel \"{}\" is not one of {}", channel, fmt::join(names, ", ")));
    indices.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  return indices;
}

/// Returns the thermometers on the inputs of an instrument, or of one of its modules.
template <class OnInputs>
OnInputs thermometers_on_inputs(const ThermometerIndices& indices, std::size_t first = 0) {
  OnInputs inputs;
  for (std::size_t i = 0; i < inputs.size() && first + i < indices.size(); ++i) inputs[i] = indices[first + i];
  return inputs;
}

std::vector<DconModule> make_modules(const VirtualThermometer& thermometer, const ThermometerIndices& indices) {
  std::vector<DconModule> modules;
  for (const auto address : thermometer.addresses)
    modules.push_back({.address = address,
                       .type = thermometer.type,
                       .checksum = thermometer.checksum,
                       .name = thermometer.module_name,
                       .inputs = thermometers_on_inputs<Inputs<drivers::kDconInputs>>(
                           indices, modules.size() * drivers::kDconInputs)});
  return modules;
}

/// Returns the factory of an instrument's sessions, or an empty one if the instrument is not a server.
MakeSession session_factory(const VirtualThermometer& thermometer, const ThermometerIndices& indices,
                            const VirtualLaboratory& laboratory) {
  switch (thermometer.kind) {
    case drivers::ThermometerKind::lakeshore_218:
      return [&laboratory, inputs = thermometers_on_inputs<Lakeshore218Session::Inputs>(indices)] {
        return std::make_unique<Lakeshore218Session>(laboratory, inputs);
      };
    case drivers::ThermometerKind::pt12:
      return [&laboratory, inputs = thermometers_on_inputs<Pt12Session::Inputs>(indices)] {
        return std::make_unique<Pt12Session>(laboratory, inputs);
      };
    case drivers::ThermometerKind::dcon:
      return [&laboratory, modules = make_modules(thermometer, indices)] {
        return std::make_unique<DconSession>(laboratory, modules);
      };
    case drivers::ThermometerKind::process:
      return [&laboratory, indices] { return std::make_unique<ProcessSession>(laboratory, indices); };
    case drivers::ThermometerKind::text:
      return [&laboratory, indices, description = thermometer.description] {
        return make_scanner_session(laboratory, *description, indices);
      };
    case drivers::ThermometerKind::mcc_usb_temp: return {};
  }
  return {};
}

/// Returns the thermometer with the serial link of its description, if there is one.
VirtualThermometer on_serial_line(VirtualThermometer thermometer) {
  if (thermometer.description && thermometer.description->unit.find(drivers::LinkKind::text_serial))
    thermometer.description->unit.link = *thermometer.description->unit.find(drivers::LinkKind::text_serial);
  return thermometer;
}

/// Opens one listener per server: chamber, thermometers, gyros, analogue inputs, in this order.
Result<std::vector<Descriptor>> listen_all(std::uint16_t first_port, std::size_t count) {
  if (first_port + count > 0x10000) {
    return failure(FaultKind::usage, "virtual instruments",
                   fmt::format("{} ports from {} on exceed 65535; choose a lower first port", count, first_port));
  }
  std::vector<Descriptor> listeners;
  for (std::size_t i = 0; i < count; ++i) {
    auto listener = listen_on_loopback(first_port == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(first_port + i));
    if (!listener) return failure(std::move(listener.error()));
    listeners.push_back(std::move(*listener));
  }
  return listeners;
}

Result<std::vector<Pty>> open_ptys(std::size_t count) {
  std::vector<Pty> ptys;
  while (ptys.size() < count) {
    auto pty = open_pty();
    if (!pty) return failure(std::move(pty.error()));
    ptys.push_back(std::move(*pty));
  }
  return ptys;
}

/// Returns "gyro", or with several lines "gyro" and the names of the units.
std::string line_name(const GyroLineSources& sources, const VirtualLaboratory& laboratory, std::size_t lines) {
  if (lines == 1) return "gyro";
  std::vector<std::string> units;
  for (const auto unit : sources.units) units.push_back(laboratory.units()[unit]);
  return fmt::format("gyro {}", fmt::join(units, "+"));
}

/// Indices of the laboratory's values that each instrument transmits.
struct Sources {
  std::vector<ThermometerIndices> thermometers;
  std::vector<GyroLineSources> gyros;
  std::vector<AnalogueRegisters> analogue;
  std::vector<VirtualSupply> supplies;
};

Result<Sources> find_instrument_sources(const VirtualLaboratory& laboratory, const VirtualInstrumentsOptions& options) {
  Sources sources;
  for (const auto& thermometer : options.thermometers) {
    auto found = find_thermometers(thermometer, laboratory);
    if (!found) return failure(std::move(found.error()));
    sources.thermometers.push_back(std::move(*found));
  }
  for (const auto& gyro : options.gyros) {
    auto found = find_sources(gyro, laboratory);
    if (!found) return failure(std::move(found.error()));
    sources.gyros.push_back(std::move(*found));
  }
  for (const auto& wired : options.analogue_inputs) {
    auto made = AnalogueRegisters::make(wired, laboratory);
    if (!made) return failure(std::move(made.error()));
    sources.analogue.push_back(std::move(*made));
  }
  for (const auto& wired : options.supplies) {
    auto made = VirtualSupply::make(wired, laboratory);
    if (!made) return failure(std::move(made.error()));
    sources.supplies.push_back(std::move(*made));
  }
  return sources;
}

class Servers final : public VirtualInstruments {
 public:
  Servers(VirtualLaboratory laboratory, VirtualInstrumentsOptions options, Sources sources,
          std::vector<Descriptor> listeners, std::vector<Pty> ptys);

  void pass(Duration time) override {
    const std::scoped_lock lock(guard_);
    clock_ += time;
    for (auto& gyro : gyros_)
      if (from_seconds(gyro.next_s()) > clock_) gyro.serve_clients();
    for (auto next = next_s(); from_seconds(next) <= clock_; next = next_s()) {
      while (static_cast<double>(seconds_) < next) step();
      for (auto& gyro : gyros_)
        if (gyro.next_s() == next) gyro.send(laboratory_, std::min(1.0, next - static_cast<double>(seconds_ - 1)));
    }
  }

  void replay(std::span<const PastSecond> seconds) override {
    const std::scoped_lock lock(guard_);
    laboratory_.switch_on(true);
    for (const auto& [set_point, unit, powered] : seconds) {
      laboratory_.change_set_point(set_point);
      laboratory_.set_unit_state(unit);
      switch_supplies(powered);
      laboratory_.step();
      for (auto& gyro : gyros_) gyro.skip(laboratory_);
    }
  }

  std::unique_ptr<drivers::ByteStream> line(InstrumentKind kind, std::size_t index) override {
    if (kind != InstrumentKind::gyro) return make_answering_line(sessions_.at(kind).at(index), guard_);
    return make_memory_line([this, index] { return gyros_.at(index).connect(); });
  }

  void set_unit_state(const UnitState& state) override {
    const std::scoped_lock lock(guard_);
    laboratory_.set_unit_state(state);
  }
  [[nodiscard]] UnitState unit() override {
    const std::scoped_lock lock(guard_);
    return laboratory_.unit();
  }
  void change_limiter(const std::function<void(ChamberLimiter&)>& change) override {
    const std::scoped_lock lock(guard_);
    change(laboratory_.limiter());
  }
  void stick_relay(bool sticks) override {
    const std::scoped_lock lock(guard_);
    if (relay_) relay_->stick(sticks);
  }
  void silence(std::size_t unit, bool silent) override {
    const std::scoped_lock lock(guard_);
    laboratory_.silence(unit, silent);
  }

  [[nodiscard]] const std::vector<std::string>& units() const override { return laboratory_.units(); }
  [[nodiscard]] const std::vector<std::string>& axes(std::size_t unit) const override { return laboratory_.axes(unit); }
  [[nodiscard]] std::vector<DegreesPerHour> true_bias(std::size_t unit) override {
    const std::scoped_lock lock(guard_);
    const auto biases = laboratory_.true_bias(unit);
    return {biases.begin(), biases.end()};
  }
  [[nodiscard]] std::uint16_t chamber_port() const override { return chamber_port_; }
  [[nodiscard]] std::uint16_t thermometer_port(std::size_t index) const override {
    return thermometer_ports_.at(index);
  }
  [[nodiscard]] std::uint16_t gyro_port(std::size_t line) const override { return gyro_ports_.at(line); }
  [[nodiscard]] std::uint16_t analogue_port(std::size_t index) const override { return analogue_ports_.at(index); }
  [[nodiscard]] std::uint16_t supply_port(std::size_t index) const override { return supply_ports_.at(index); }
  [[nodiscard]] std::uint16_t relay_port() const override { return relay_port_; }
  [[nodiscard]] std::vector<ServedLine> lines() const override { return lines_; }
  [[nodiscard]] std::unique_ptr<drivers::HidReports> usb_temp(std::size_t index) override {
    return std::make_unique<VirtualUsbTemp>(
        laboratory_, guard_, thermometers_on_inputs<VirtualUsbTemp::Inputs>(thermometer_indices_.at(index)));
  }

 private:
  void step() {
    for (auto& gyro : gyros_) gyro.begin_second(laboratory_);
    chamber_.advance_second();
    laboratory_.step();
    for (auto& supply : supplies_) supply.advance_second();
    for (auto& gyro : gyros_) gyro.end_second(laboratory_);
    ++seconds_;
  }

  void switch_supplies(const std::vector<bool>& powered) {
    std::size_t next = 0;
    for (auto& supply : supplies_)
      for (std::size_t i = 0; i < supply.wired_outputs() && next < powered.size(); ++i)
        supply.replay(i, powered[next++]);
  }

  /// Returns the time of the next frame, or without gyros the end of the next second, in seconds since the start.
  [[nodiscard]] double next_s() const {
    if (gyros_.empty()) return static_cast<double>(seconds_ + 1);
    double next = gyros_.front().next_s();
    for (const auto& gyro : gyros_) next = std::min(next, gyro.next_s());
    return next;
  }

  /// Removes and returns the next listener. Returns a closed one if none is left, as for attended instruments.
  static Descriptor take_listener(std::vector<Descriptor>& listeners) {
    if (listeners.empty()) return {};
    auto next = std::move(listeners.front());
    listeners.erase(listeners.begin());
    return next;
  }

  std::uint16_t serve(const std::string& instrument, Descriptor listener, const MakeSession& session) {
    if (!listener.is_open()) return 0;
    const auto port = listening_port(listener);
    lines_.push_back({instrument, fmt::format("tcp://127.0.0.1:{}", port)});
    replies_.add(std::move(listener), session);
    return port;
  }

  void serve(const std::string& instrument, Pty line, const MakeSession& session) {
    lines_.push_back({instrument, "serial:" + line.path});
    replies_.add(std::move(line), session);
  }

  void serve_gyro(VirtualGyroLine line, const GyroLineSources& sources, const VirtualInstrumentsOptions& options,
                  Descriptor listener, std::optional<Pty> pty) {
    const auto name = line_name(sources, laboratory_, options.gyros.size());
    gyro_ports_.push_back(listener.is_open() ? listening_port(listener) : std::uint16_t{0});
    if (listener.is_open()) lines_.push_back({name, fmt::format("tcp://127.0.0.1:{}", gyro_ports_.back())});
    gyros_.emplace_back(std::move(line), sources, options.frames, laboratory_.arcsec_per_pulse(), std::move(listener));
    if (!pty) return;
    lines_.push_back({name, "serial:" + pty->path});
    gyros_.back().add(std::move(*pty));
  }

  void serve_supply(std::size_t index, Descriptor listener, std::optional<Pty> pty) {
    auto& supply = supplies_[index];
    supply.connect(laboratory_, index);
    const auto instrument = fmt::format("supply {}", index + 1);
    const auto& unit = supply.description().unit;
    const MakeSession session = [&supply, link = unit.link] { return make_supply_session(supply, link); };
    sessions_[InstrumentKind::supply].push_back(session);
    supply_ports_.push_back(serve(instrument, std::move(listener), session));
    if (!pty) return;
    const auto* serial = unit.find(drivers::LinkKind::text_serial);
    serve(instrument, std::move(*pty),
          [&supply, link = serial ? *serial : unit.link] { return make_supply_session(supply, link); });
  }

  /// Guards the laboratory and everything that reads it.
  std::mutex guard_;
  VirtualLaboratory laboratory_;
  ChamberRegisters chamber_;
  std::vector<ThermometerIndices> thermometer_indices_;
  std::uint16_t chamber_port_{};
  std::vector<AnalogueRegisters> analogue_;
  std::vector<VirtualSupply> supplies_;
  std::optional<VirtualRelay> relay_;
  std::uint16_t relay_port_{};
  std::vector<std::uint16_t> thermometer_ports_, gyro_ports_, analogue_ports_, supply_ports_;
  std::vector<ServedLine> lines_;
  std::map<InstrumentKind, std::vector<MakeSession>> sessions_;
  std::vector<PacedGyroLine> gyros_;
  /// Time since the start.
  Duration clock_{};
  std::int64_t seconds_{};
  /// Declared last: its thread ends before the members that it uses.
  ReplyServer replies_;
};

Servers::Servers(VirtualLaboratory laboratory, VirtualInstrumentsOptions options, Sources sources,
                 std::vector<Descriptor> listeners, std::vector<Pty> ptys)
    : laboratory_(std::move(laboratory)),
      chamber_(std::move(options.chamber), laboratory_, !options.attended),
      thermometer_indices_(std::move(sources.thermometers)),
      analogue_(std::move(sources.analogue)),
      supplies_(std::move(sources.supplies)),
      replies_(guard_) {
  auto pty = ptys.begin();
  const bool is_text_unit = drivers::is_text(chamber_.map().link.kind);
  const bool has_lag = !options.attended;
  const MakeSession chamber = [this, is_text_unit, has_lag] {
    return is_text_unit ? make_text_session(chamber_, chamber_.map().link.kind, has_lag)
                        : make_modbus_session(chamber_);
  };
  sessions_[InstrumentKind::chamber] = {chamber};
  chamber_port_ = serve("chamber", take_listener(listeners), chamber);
  if (options.ptys)
    serve("chamber", std::move(*pty++), [this, is_text_unit]() -> std::unique_ptr<Session> {
      if (is_text_unit) return make_text_session(chamber_, drivers::LinkKind::text_serial, true);
      return std::make_unique<ModbusRtuSession>(chamber_, drivers::LinkKind::rtu);
    });
  for (std::size_t i = 0; i < thermometer_indices_.size(); ++i) {
    const auto instrument = fmt::format("thermometer {}", i + 1);
    const auto session = session_factory(options.thermometers[i], thermometer_indices_[i], laboratory_);
    sessions_[InstrumentKind::thermometer].push_back(session);
    thermometer_ports_.push_back(session ? serve(instrument, take_listener(listeners), session) : std::uint16_t{0});
    if (session && options.ptys)
      serve(instrument, std::move(*pty++),
            session_factory(on_serial_line(options.thermometers[i]), thermometer_indices_[i], laboratory_));
  }
  for (std::size_t i = 0; i < options.gyros.size(); ++i)
    serve_gyro(std::move(options.gyros[i]), sources.gyros[i], options, take_listener(listeners),
               options.ptys ? std::optional(std::move(*pty++)) : std::nullopt);
  for (std::size_t i = 0; i < analogue_.size(); ++i) {
    analogue_[i].watch(laboratory_);
    const auto instrument = fmt::format("analogue input {}", i + 1);
    const MakeSession session = [this, i] { return make_modbus_session(analogue_[i]); };
    sessions_[InstrumentKind::analogue_input].push_back(session);
    analogue_ports_.push_back(serve(instrument, take_listener(listeners), session));
    if (options.ptys)
      serve(instrument, std::move(*pty++),
            [this, i] { return std::make_unique<ModbusRtuSession>(analogue_[i], drivers::LinkKind::rtu); });
  }
  for (std::size_t i = 0; i < supplies_.size(); ++i)
    serve_supply(i, take_listener(listeners), options.ptys ? std::optional(std::move(*pty++)) : std::nullopt);
  if (options.relay) {
    relay_.emplace(*options.relay, laboratory_);
    relay_port_ = serve("relay", take_listener(listeners), [this] { return make_relay_session(*relay_); });
  }
  if (!options.attended) replies_.start();
}

}  // namespace

Result<std::unique_ptr<VirtualInstruments>> VirtualInstruments::start(VirtualLaboratory laboratory,
                                                                      VirtualInstrumentsOptions options) {
  if (!options.attended) mark_identities(options);
  auto sources = find_instrument_sources(laboratory, options);
  if (!sources) return failure(std::move(sources.error()));
  const auto usb_count =
      std::ranges::count(options.thermometers, drivers::ThermometerKind::mcc_usb_temp, &VirtualThermometer::kind);
  const auto servers = 1 + options.thermometers.size() - static_cast<std::size_t>(usb_count) + options.gyros.size() +
                       options.analogue_inputs.size() + options.supplies.size();
  auto listeners = listen_all(options.first_port, options.attended ? 0 : servers + (options.relay ? 1 : 0));
  if (!listeners) return failure(std::move(listeners.error()));
  auto ptys = open_ptys(options.ptys ? servers : 0);
  if (!ptys) return failure(std::move(ptys.error()));
  return std::make_unique<Servers>(std::move(laboratory), std::move(options), std::move(*sources),
                                   std::move(*listeners), std::move(*ptys));
}

}  // namespace gyrotherm::simulator
