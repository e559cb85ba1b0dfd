#include "simulator/virtual_instruments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "simulator/chamber_registers.hpp"
#include "simulator/gyro_server.hpp"
#include "simulator/lakeshore_218_server.hpp"
#include "simulator/modbus_server.hpp"
#include "simulator/reply_server.hpp"

namespace gyrotherm {
namespace {

Result<Lakeshore218Session::Inputs> inputs_of(const VirtualThermometer& thermometer, const World& world) {
  Lakeshore218Session::Inputs inputs;
  if (thermometer.channels.size() > inputs.size()) {
    return failure(FaultKind::usage, "virtual thermometer", fmt::format("more than {} channels", inputs.size()));
  }
  const auto& names = world.thermometer_names();
  for (std::size_t i = 0; i < thermometer.channels.size(); ++i) {
    const auto found = std::ranges::find(names, thermometer.channels[i]);
    if (found == names.end()) {
      return failure(FaultKind::usage, "virtual thermometer",
                     fmt::format("channel \"{}\" is none of {}", thermometer.channels[i], fmt::join(names, ", ")));
    }
    inputs[i] = static_cast<std::size_t>(found - names.begin());
  }
  return inputs;
}

/// Chamber, thermometers, gyro, in this order.
Result<std::vector<Socket>> listen_all(std::uint16_t first_port, std::size_t count) {
  if (first_port + count > 0x10000) {
    return failure(FaultKind::usage, "virtual instruments",
                   fmt::format("{} ports from {} on, but the last one is 65535", count, first_port));
  }
  std::vector<Socket> listeners;
  for (std::size_t i = 0; i < count; ++i) {
    auto listener = listen_on_loopback(first_port == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(first_port + i));
    if (!listener) return failure(std::move(listener.error()));
    listeners.push_back(std::move(*listener));
  }
  return listeners;
}

std::vector<std::uint16_t> ports_of(const std::vector<Socket>& listeners) {
  std::vector<std::uint16_t> ports(listeners.size());
  std::ranges::transform(listeners, ports.begin(), port_of);
  return ports;
}

class Servers final : public VirtualInstruments {
 public:
  Servers(World world, VirtualInstrumentsOptions options, std::vector<Lakeshore218Session::Inputs> inputs,
          std::vector<Socket> listeners);

  void advance(int seconds) override;
  void replay(std::span<const Celsius> set_points) override;
  [[nodiscard]] std::uint16_t chamber_port() const override { return ports_.front(); }
  [[nodiscard]] std::uint16_t thermometer_port(std::size_t index) const override { return ports_.at(index + 1); }
  [[nodiscard]] std::uint16_t gyro_port() const override { return ports_.back(); }

 private:
  std::mutex guard_;  ///< of the world and what reads it
  World world_;
  ChamberRegisters chamber_;
  std::vector<std::uint16_t> ports_;
  GyroServer gyro_;
  ReplyServer replies_;  ///< last: its thread ends before what it uses
};

Servers::Servers(World world, VirtualInstrumentsOptions options, std::vector<Lakeshore218Session::Inputs> inputs,
                 std::vector<Socket> listeners)
    : world_(std::move(world)),
      chamber_(std::move(options.chamber), world_),
      ports_(ports_of(listeners)),
      gyro_(std::move(listeners.back()), std::move(options.gyro)),
      replies_(guard_) {
  replies_.add(std::move(listeners.front()), [this] { return std::make_unique<ModbusSession>(chamber_); });
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    replies_.add(std::move(listeners[i + 1]),
                 [this, own = inputs[i]] { return std::make_unique<Lakeshore218Session>(world_, own); });
  }
  replies_.start();
}

void Servers::advance(int seconds) {
  const std::scoped_lock lock(guard_);
  for (int i = 0; i < seconds; ++i) {
    world_.step();
    gyro_.send(world_.pulses(), world_.device_time_us());
  }
}

void Servers::replay(std::span<const Celsius> set_points) {
  const std::scoped_lock lock(guard_);
  world_.switch_on(true);
  for (const auto set_point : set_points) {
    world_.command(set_point);
    world_.step();
    gyro_.skip(world_.pulses());
  }
}

}  // namespace

Result<std::unique_ptr<VirtualInstruments>> VirtualInstruments::start(World world, VirtualInstrumentsOptions options) {
  std::vector<Lakeshore218Session::Inputs> inputs;
  for (const auto& thermometer : options.thermometers) {
    auto found = inputs_of(thermometer, world);
    if (!found) return failure(std::move(found.error()));
    inputs.push_back(*found);
  }
  auto listeners = listen_all(options.first_port, options.thermometers.size() + 2);
  if (!listeners) return failure(std::move(listeners.error()));
  return std::make_unique<Servers>(std::move(world), std::move(options), std::move(inputs), std::move(*listeners));
}

}  // namespace gyrotherm
