// SPDX-License-Identifier: Apache-2.0
/// The virtual instruments: servers on loopback that speak the real protocols over a world.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/register_map.hpp"
#include "drivers/thermometer/thermometer_kinds.hpp"
#include "drivers/wires.hpp"
#include "simulator/analogue_registers.hpp"
#include "simulator/virtual_gyro_line.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// One thermometer of the virtual rig: which of the world's are on its inputs, in order; on DCON modules eight to each.
struct VirtualThermometer {
  std::vector<std::string> channels;
  drivers::ThermometerKind kind{};
  std::vector<std::uint8_t> addresses{1};  ///< DCON: of the modules on the line
  std::uint8_t type = 0x10;                ///< DCON: of all their inputs
  drivers::DconChecksum checksum{};
};

struct VirtualInstrumentsOptions {
  drivers::RegisterMap chamber;
  std::vector<VirtualThermometer> thermometers;
  std::vector<VirtualGyroLine> gyros;  ///< each with a pace of its own
  std::vector<VirtualAnalogueInput> analogue_inputs{};
  std::uint16_t first_port = 0;  ///< 0: any free ones; else chamber, thermometers, gyros, analogue inputs on
                                 ///< consecutive ones
  FramePace frames{};            ///< of all gyros
  bool ptys = false;  ///< serves all but HID devices on pseudo-terminals too; there chamber and analogue inputs speak
                      ///< Modbus RTU, with unit and registers of the map's link in use
  bool attended = false;  ///< they are at no port and have no thread: the one client, in this process, has lines from
                          ///< line() and connect()
};

/// One second that the laboratory lives through again.
struct PastSecond {
  Celsius set_point;
  UnitState unit{};
};

/// Where one of them can be reached: "chamber", "thermometer 1", …, "gyro" (where there are several, "gyro UNIT", or
/// "gyro UNIT+UNIT" where two share a line), "analogue input 1", … at "tcp://127.0.0.1:5020" or
/// "serial:/dev/pts/3".
struct ServedLine {
  std::string instrument, line;
};

enum class InstrumentKind { chamber, thermometer, gyro, analogue_input };

/// Serves on 127.0.0.1 from a thread of its own until destroyed, unless attended. All clients see one world; several
/// clients may connect to each.
class VirtualInstruments {
 public:
  /// Fails with disconnected if a port cannot be bound, or usage if a channel is not a thermometer of the world, an
  /// instrument has too many, a gyro line's axes are not the world's or not as many as its frame's, or an analogue
  /// input shows what the world has not (AnalogueRegisters::make).
  [[nodiscard]] static Result<std::unique_ptr<VirtualInstruments>> start(VirtualLaboratory laboratory,
                                                                         VirtualInstrumentsOptions options);
  virtual ~VirtualInstruments() = default;

  /// Lets `time` pass: the gyros send the frames that have become due to whoever is connected. The world moves in whole
  /// seconds, each with its first frame; what the frames of a second say adds up to the second exactly. Without gyros a
  /// second comes when it is over.
  virtual void pass(Duration time) = 0;
  void advance(int seconds) { pass(std::chrono::seconds(seconds)); }
  /// Lets these seconds pass with nobody listening: how a recorded run is replayed.
  virtual void replay(std::span<const PastSecond> seconds) = 0;
  /// Brings all units to a state, as people would; from the next second on.
  virtual void bring_unit_to(const UnitState& state) = 0;
  /// The state it was brought to last, in the seconds lived through again too.
  [[nodiscard]] virtual UnitState unit() = 0;

  /// Of attended instruments: the line to one of them, a gyro's by its line, in memory. What is asked is answered at
  /// once, by gyros when time passes next. Must not outlive this.
  [[nodiscard]] virtual std::unique_ptr<drivers::ByteStream> line(InstrumentKind kind, std::size_t index = 0) = 0;
  /// Of an attended chamber or analogue input that speaks Modbus TCP: a connection, for a client that wants a
  /// descriptor; not blocking. Fails with disconnected.
  [[nodiscard]] virtual Result<Descriptor> connect(InstrumentKind kind, std::size_t index = 0) = 0;
  /// After something was sent on such a connection: it is answered.
  virtual void attend() = 0;

  /// A unit that does not send (VirtualLaboratory::silence).
  virtual void silence(std::size_t unit, bool silent) = 0;

  /// The world's units and their axes (VirtualLaboratory), by whose places these functions know them.
  [[nodiscard]] virtual const std::vector<std::string>& units() const = 0;
  [[nodiscard]] virtual const std::vector<std::string>& axes(std::size_t unit = 0) const = 0;
  /// Of each axis of a unit (VirtualLaboratory::true_bias): asked of the laboratory, by no instrument's line.
  [[nodiscard]] virtual std::vector<DegreesPerHour> true_bias(std::size_t unit = 0) = 0;

  /// Ports on 127.0.0.1; 0: that thermometer is no server (USB-TEMP), or all are attended.
  [[nodiscard]] virtual std::uint16_t chamber_port() const = 0;
  [[nodiscard]] virtual std::uint16_t thermometer_port(std::size_t index) const = 0;
  [[nodiscard]] virtual std::uint16_t gyro_port(std::size_t line = 0) const = 0;
  [[nodiscard]] virtual std::uint16_t analogue_port(std::size_t index) const = 0;
  /// Every port and pseudo-terminal, in the order of the instruments.
  [[nodiscard]] virtual std::vector<ServedLine> lines() const = 0;

  /// The wire of a USB-TEMP, in memory; must not outlive this.
  [[nodiscard]] virtual std::unique_ptr<drivers::HidReports> usb_temp(std::size_t index) = 0;
};

}  // namespace gyrotherm::simulator
