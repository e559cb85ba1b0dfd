// SPDX-License-Identifier: Apache-2.0
/// The virtual instruments: servers on loopback that use the real protocols and serve a virtual laboratory.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/supply/safety_relay.hpp"
#include "drivers/thermometer/thermometer_kinds.hpp"
#include "drivers/wires.hpp"
#include "simulator/analogue_registers.hpp"
#include "simulator/chamber_limiter.hpp"
#include "simulator/virtual_gyro_line.hpp"
#include "simulator/virtual_laboratory.hpp"
#include "simulator/virtual_supply.hpp"

namespace gyrotherm::simulator {

/// One thermometer instrument of the virtual rig. `channels` names the laboratory's thermometers on its inputs, in
/// order; a DCON module has eight inputs.
struct VirtualThermometer {
  std::vector<std::string> channels;
  drivers::ThermometerKind kind{};
  /// DCON: addresses of the modules on the line, and the type of all their inputs.
  std::vector<std::uint8_t> addresses{1};
  std::uint8_t type = 0x10;
  drivers::DconChecksum checksum{};
  std::string module_name = "7018";
  /// Text: the description of the instrument.
  std::optional<drivers::ThermometerDescription> description{};
};

struct VirtualInstrumentsOptions {
  drivers::RegisterMap chamber;
  std::vector<VirtualThermometer> thermometers;
  /// Each line has its own frame rate.
  std::vector<VirtualGyroLine> gyros;
  std::vector<VirtualAnalogueInput> analogue_inputs{};
  std::vector<VirtualSupplyOptions> supplies{};
  /// Relay that disconnects the chamber; it is served on a port, not on a pseudo-terminal.
  std::optional<drivers::RelaySettings> relay{};
  /// First port: chamber, thermometers, gyros, analogue inputs, supplies and the relay use consecutive ports from it
  /// on. 0 selects free ports.
  std::uint16_t first_port = 0;
  /// Frame rate of all gyro lines.
  FramePace frames{};
  /// Also serves all instruments except HID devices on pseudo-terminals. On pseudo-terminals, chamber and analogue
  /// inputs use Modbus RTU with the unit number and the registers of the map's link.
  bool ptys = false;
  /// Opens no port and starts no thread. The single client in this process uses line(). Unless attended, the
  /// instruments report identities by which any client recognises them as virtual (drivers/virtual_identity.hpp).
  bool attended = false;
};

/// One second of a recorded run for replay.
struct PastSecond {
  Celsius set_point;
  UnitState unit{};
  /// State of each wired output of all supplies, in order; empty: unchanged.
  std::vector<bool> powered{};
};

/// Address of an instrument. Names are "chamber", "thermometer 1", …, "gyro" (with several lines "gyro UNIT", or "gyro
/// UNIT+UNIT" if two units share a line), "analogue input 1", … and "supply 1", …; lines are "tcp://127.0.0.1:5020" or
/// "serial:/dev/pts/3".
struct ServedLine {
  std::string instrument, line;
};

enum class InstrumentKind { chamber, thermometer, gyro, analogue_input, supply };

/// Serves on 127.0.0.1 from its own thread until destroyed, unless attended. All clients observe one laboratory.
/// Several clients may connect to each instrument.
class VirtualInstruments {
 public:
  /// Starts the servers. Fails with disconnected if a port cannot be bound. Fails with usage if a channel is not a
  /// thermometer of the laboratory, an instrument has too many channels, the axes of a gyro line do not match
  /// laboratory and frame, or an analogue input is wired to an unknown value (AnalogueRegisters::make).
  [[nodiscard]] static Result<std::unique_ptr<VirtualInstruments>> start(VirtualLaboratory laboratory,
                                                                         VirtualInstrumentsOptions options);
  virtual ~VirtualInstruments() = default;

  /// Advances by `time`. The gyros send all due frames to the connected clients. The laboratory advances by a whole
  /// second when the first frame of that second is due, or without gyros at the end of the second. The frames of a
  /// second add up exactly to its pulses.
  virtual void pass(Duration time) = 0;
  void advance(int seconds) { pass(std::chrono::seconds(seconds)); }
  /// Replays seconds of a recorded run without sending. The supplies keep the state of the last second.
  virtual void replay(std::span<const PastSecond> seconds) = 0;
  /// Changes the state of all units from the next second on, as an operator would.
  virtual void set_unit_state(const UnitState& state) = 0;
  /// Returns the last requested state, also during a replay.
  [[nodiscard]] virtual UnitState unit() = 0;

  /// Returns an in-memory line to an attended instrument. Requests are answered immediately; gyros send when the time
  /// advances. The line must not outlive this object.
  [[nodiscard]] virtual std::unique_ptr<drivers::ByteStream> line(InstrumentKind kind, std::size_t index = 0) = 0;

  /// Lets a person change the chamber's limiter.
  virtual void change_limiter(const std::function<void(ChamberLimiter&)>& change) = 0;
  /// Makes the relay stick, or work again. Does nothing without a relay.
  virtual void stick_relay(bool sticks) = 0;
  /// Makes a unit stop or resume sending (VirtualLaboratory::silence).
  virtual void silence(std::size_t unit, bool silent) = 0;

  /// Returns the names of the units and of their axes (VirtualLaboratory). Other functions use their indices.
  [[nodiscard]] virtual const std::vector<std::string>& units() const = 0;
  [[nodiscard]] virtual const std::vector<std::string>& axes(std::size_t unit = 0) const = 0;
  /// Returns the true bias of each axis of a unit (VirtualLaboratory::true_bias). No instrument transmits it.
  [[nodiscard]] virtual std::vector<DegreesPerHour> true_bias(std::size_t unit = 0) = 0;

  /// Returns a port on 127.0.0.1, or 0 if the thermometer is not a server (USB-TEMP) or the instruments are attended.
  [[nodiscard]] virtual std::uint16_t chamber_port() const = 0;
  [[nodiscard]] virtual std::uint16_t thermometer_port(std::size_t index) const = 0;
  [[nodiscard]] virtual std::uint16_t gyro_port(std::size_t line = 0) const = 0;
  [[nodiscard]] virtual std::uint16_t analogue_port(std::size_t index) const = 0;
  [[nodiscard]] virtual std::uint16_t supply_port(std::size_t index) const = 0;
  [[nodiscard]] virtual std::uint16_t relay_port() const = 0;
  /// Returns all ports and pseudo-terminals in the order of the instruments.
  [[nodiscard]] virtual std::vector<ServedLine> lines() const = 0;

  /// Returns the in-memory connection of a USB-TEMP. It must not outlive this object.
  [[nodiscard]] virtual std::unique_ptr<drivers::HidReports> usb_temp(std::size_t index) = 0;
};

}  // namespace gyrotherm::simulator
