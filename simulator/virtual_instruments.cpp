// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_instruments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "simulator/chamber_registers.hpp"
#include "simulator/servers/gyro_server.hpp"
#include "simulator/servers/modbus_server.hpp"
#include "simulator/servers/reply_server.hpp"
#include "simulator/servers/virtual_thermometers.hpp"

namespace gyrotherm::simulator {
namespace {

/// Indices of the world's thermometers, in the order of an instrument's inputs.
using Places = std::vector<std::size_t>;

std::size_t inputs_of(const VirtualThermometer& thermometer) {
  const auto modules = thermometer.kind == drivers::ThermometerKind::dcon ? thermometer.addresses.size() : 1;
  return row_of(thermometer.kind).inputs * modules;
}

Result<Places> places_of(const VirtualThermometer& thermometer, const VirtualLaboratory& laboratory) {
  if (thermometer.channels.size() > inputs_of(thermometer))
    return failure(FaultKind::usage, "virtual thermometer",
                   fmt::format("more than {} channels", inputs_of(thermometer)));
  const auto& names = laboratory.thermometer_names();
  Places places;
  for (const auto& channel : thermometer.channels) {
    const auto found = std::ranges::find(names, channel);
    if (found == names.end())
      return failure(FaultKind::usage, "virtual thermometer",
                     fmt::format("channel \"{}\" is none of {}", channel, fmt::join(names, ", ")));
    places.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  return places;
}

/// Those of one instrument, or of one module of several.
template <class OnInputs>
OnInputs on_inputs(const Places& places, std::size_t first = 0) {
  OnInputs inputs;
  for (std::size_t i = 0; i < inputs.size() && first + i < places.size(); ++i) inputs[i] = places[first + i];
  return inputs;
}

std::vector<DconModule> modules_of(const VirtualThermometer& thermometer, const Places& places) {
  std::vector<DconModule> modules;
  for (const auto address : thermometer.addresses)
    modules.push_back(
        {.address = address,
         .type = thermometer.type,
         .checksum = thermometer.checksum,
         .inputs = on_inputs<Inputs<drivers::kDconInputs>>(places, modules.size() * drivers::kDconInputs)});
  return modules;
}

/// Nothing for an instrument that is no server.
MakeSession session_of(const VirtualThermometer& thermometer, const Places& places,
                       const VirtualLaboratory& laboratory) {
  switch (thermometer.kind) {
    case drivers::ThermometerKind::lakeshore_218:
      return [&laboratory, inputs = on_inputs<Lakeshore218Session::Inputs>(places)] {
        return std::make_unique<Lakeshore218Session>(laboratory, inputs);
      };
    case drivers::ThermometerKind::pt12:
      return [&laboratory, inputs = on_inputs<Pt12Session::Inputs>(places)] {
        return std::make_unique<Pt12Session>(laboratory, inputs);
      };
    case drivers::ThermometerKind::dcon:
      return [&laboratory, modules = modules_of(thermometer, places)] {
        return std::make_unique<DconSession>(laboratory, modules);
      };
    case drivers::ThermometerKind::mcc_usb_temp: return {};
  }
  return {};
}

/// One for each instrument that is a server: chamber, thermometers, gyro, in this order.
Result<std::vector<Descriptor>> listen_all(std::uint16_t first_port, std::size_t count) {
  if (first_port + count > 0x10000) {
    return failure(FaultKind::usage, "virtual instruments",
                   fmt::format("{} ports from {} on, but the last one is 65535", count, first_port));
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

drivers::FrameFormat gyro_format(const VirtualInstrumentsOptions& options) {
  return options.frames == FramePace::full_rate ? options.gyro : at_one_frame_a_second(options.gyro);
}

class Servers final : public VirtualInstruments {
 public:
  Servers(VirtualLaboratory laboratory, VirtualInstrumentsOptions options, std::vector<Places> places,
          std::vector<Descriptor> listeners, std::vector<Pty> ptys);

  void pass(Duration time) override {
    const std::scoped_lock lock(guard_);
    clock_ += time;
    if (from_seconds(next_frame()) > clock_) return gyro_.attend();
    for (auto next = next_frame(); from_seconds(next) <= clock_; next = next_frame()) {
      if (static_cast<double>(seconds_) < next) step();
      send_frame(next);
    }
  }

  void replay(std::span<const PastSecond> seconds) override {
    const std::scoped_lock lock(guard_);
    laboratory_.switch_on(true);
    for (const auto& [set_point, unit] : seconds) {
      laboratory_.command(set_point);
      laboratory_.bring_unit_to(unit);
      laboratory_.step();
      gyro_.skip(static_cast<double>(laboratory_.pulses()));
    }
  }

  void bring_unit_to(const UnitState& state) override {
    const std::scoped_lock lock(guard_);
    laboratory_.bring_unit_to(state);
  }

  [[nodiscard]] UnitState unit() override {
    const std::scoped_lock lock(guard_);
    return laboratory_.unit();
  }

  [[nodiscard]] DegreesPerHour true_bias() override {
    const std::scoped_lock lock(guard_);
    return laboratory_.true_bias();
  }
  [[nodiscard]] std::uint16_t chamber_port() const override { return chamber_port_; }
  [[nodiscard]] std::uint16_t thermometer_port(std::size_t index) const override {
    return thermometer_ports_.at(index);
  }
  [[nodiscard]] std::uint16_t gyro_port() const override { return gyro_port_; }
  [[nodiscard]] std::vector<ServedLine> lines() const override { return lines_; }
  [[nodiscard]] std::unique_ptr<drivers::HidReports> usb_temp(std::size_t index) override {
    return std::make_unique<VirtualUsbTemp>(laboratory_, guard_, on_inputs<VirtualUsbTemp::Inputs>(places_.at(index)));
  }

 private:
  /// Where the gyro stands at the ends of the second under way.
  struct Stand {
    std::int64_t pulses{};
    std::int64_t device_time_us{};
  };
  [[nodiscard]] Stand stand() const { return {laboratory_.pulses(), laboratory_.device_time_us()}; }

  void step() {
    before_ = stand();
    chamber_.pass_second();
    laboratory_.step();
    after_ = stand();
    ++seconds_;
  }

  /// When the next frame is due, seconds since the start.
  [[nodiscard]] double next_frame() const { return static_cast<double>(frames_ + 1) / frames_a_second_; }

  /// At its place between the ends of its second.
  void send_frame(double at_s) {
    ++frames_;
    if (laboratory_.unit().off) return gyro_.attend();
    const double share = std::min(1.0, at_s - static_cast<double>(seconds_ - 1));
    const auto between = [share](std::int64_t from, std::int64_t to) {
      return static_cast<double>(from) + share * static_cast<double>(to - from);
    };
    gyro_.send(between(before_.pulses, after_.pulses),
               std::llround(between(before_.device_time_us, after_.device_time_us)), 1 / frames_a_second_);
  }

  std::uint16_t serve(const std::string& instrument, Descriptor listener, const MakeSession& session) {
    const auto port = port_of(listener);
    lines_.push_back({instrument, fmt::format("tcp://127.0.0.1:{}", port)});
    replies_.add(std::move(listener), session);
    return port;
  }

  void serve(const std::string& instrument, Pty line, const MakeSession& session) {
    lines_.push_back({instrument, "serial:" + line.path});
    replies_.add(std::move(line), session);
  }

  std::mutex guard_;  ///< of the world and what reads it
  VirtualLaboratory laboratory_;
  ChamberRegisters chamber_;
  std::vector<Places> places_;  ///< of each thermometer
  std::uint16_t chamber_port_{}, gyro_port_{};
  std::vector<std::uint16_t> thermometer_ports_;
  std::vector<ServedLine> lines_;
  GyroServer gyro_;
  double frames_a_second_;
  Duration clock_{};  ///< since the start
  std::int64_t seconds_{}, frames_{};
  Stand before_, after_;
  ReplyServer replies_;  ///< last: its thread ends before what it uses
};

Servers::Servers(VirtualLaboratory laboratory, VirtualInstrumentsOptions options, std::vector<Places> places,
                 std::vector<Descriptor> listeners, std::vector<Pty> ptys)
    : laboratory_(std::move(laboratory)),
      chamber_(std::move(options.chamber), laboratory_),
      places_(std::move(places)),
      gyro_port_(port_of(listeners.back())),
      gyro_(std::move(listeners.back()), StreamWriter(gyro_format(options), laboratory_.arcsec_per_pulse()),
            std::move(options.gyro_commands)),
      frames_a_second_(options.frames == FramePace::full_rate && options.gyro.rate_hz > 0 ? options.gyro.rate_hz : 1),
      replies_(guard_) {
  auto listener = listeners.begin();
  auto pty = ptys.begin();
  const MakeSession chamber = [this] { return make_modbus_session(chamber_); };
  chamber_port_ = serve("chamber", std::move(*listener++), chamber);
  if (options.ptys)
    serve("chamber", std::move(*pty++),
          [this] { return std::make_unique<ModbusRtuSession>(chamber_, drivers::LinkKind::rtu); });
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto instrument = fmt::format("thermometer {}", i + 1);
    const auto session = session_of(options.thermometers[i], places_[i], laboratory_);
    thermometer_ports_.push_back(session ? serve(instrument, std::move(*listener++), session) : std::uint16_t{0});
    if (session && options.ptys) serve(instrument, std::move(*pty++), session);
  }
  lines_.push_back({"gyro", fmt::format("tcp://127.0.0.1:{}", gyro_port_)});
  if (options.ptys) {
    lines_.push_back({"gyro", "serial:" + pty->path});
    gyro_.add(std::move(*pty));
  }
  replies_.start();
}

}  // namespace

Result<std::unique_ptr<VirtualInstruments>> VirtualInstruments::start(VirtualLaboratory laboratory,
                                                                      VirtualInstrumentsOptions options) {
  std::vector<Places> places;
  std::size_t servers = 2;  // chamber and gyro
  for (const auto& thermometer : options.thermometers) {
    auto found = places_of(thermometer, laboratory);
    if (!found) return failure(std::move(found.error()));
    places.push_back(std::move(*found));
    servers += thermometer.kind == drivers::ThermometerKind::mcc_usb_temp ? 0 : 1;
  }
  auto listeners = listen_all(options.first_port, servers);
  if (!listeners) return failure(std::move(listeners.error()));
  auto ptys = open_ptys(options.ptys ? servers : 0);
  if (!ptys) return failure(std::move(ptys.error()));
  return std::make_unique<Servers>(std::move(laboratory), std::move(options), std::move(places), std::move(*listeners),
                                   std::move(*ptys));
}

}  // namespace gyrotherm::simulator
