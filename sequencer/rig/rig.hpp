// SPDX-License-Identifier: Apache-2.0
/// A rig assembled from its file: instruments on their lines, an InstrumentIo and a clock. Only this part distinguishes
/// virtual from real rigs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/io/instrument_io.hpp"
#include "core/clock.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"
#include "drivers/chamber/chamber_lock.hpp"
#include "drivers/line/pauses.hpp"
#include "drivers/wires.hpp"
#include "sequencer/rig/rig_file.hpp"
#include "sequencer/rig/wires.hpp"
#include "simulator/virtual_instruments.hpp"

namespace gyrotherm::rig {

struct ServeOptions {
  /// 0: any free ports.
  std::uint16_t first_port = 0;
  simulator::FramePace frames{};
  bool ptys = false;
  /// First set point of the profile to run. A rig with `soaked` starts at it.
  std::optional<Celsius> first_set_point{};
  bool attended = false;  ///< see VirtualInstrumentsOptions
};
/// Starts the virtual instruments of a rig file on loopback (see VirtualInstrumentsOptions). For a real rig with one
/// axis, starts virtual instruments of the kinds, maps and streams that it names, in the world of the shipped virtual
/// rig. Fails with usage for other real rigs. Otherwise fails like parse_laboratory and VirtualInstruments::start.
[[nodiscard]] Result<std::unique_ptr<simulator::VirtualInstruments>> serve_virtual(const RigFile& file,
                                                                                   simulator::LaboratorySeed seed,
                                                                                   const ServeOptions& how = {});

/// The state of a rig before its first second.
struct RigStart {
  simulator::LaboratorySeed seed;  ///< virtual rig
  /// Time that the run had already covered before a resume; 0 for a new run.
  Duration elapsed{};
  /// Every past second of a virtual rig since it was switched on, except the last one.
  std::vector<simulator::PastSecond> replay;
  /// First set point of the profile (virtual rig).
  std::optional<Celsius> first_set_point{};
  /// On a resume, the run starts even if the units are silent.
  bool units_may_be_off{};
  /// Demand on the power supplies before the first second. `keep` only reads their state, on a resume.
  drivers::PowerDemand power = drivers::PowerDemand::on;
  /// The run starts even if these units are silent: those of empty positions, and on a resume the dropped ones.
  std::vector<std::string> dropped_units{};
};

/// The chamber's title among a rig's instruments.
inline constexpr const char* kChamberTitle = "chamber";

/// State and settings of the chamber before the run commands it.
struct FoundChamber {
  ChamberState state;
  /// Range of set points that the controller is configured to accept.
  drivers::SetPointRange limits;
  /// Descriptions of the state and alarm registers that the chamber does not have.
  std::vector<std::string> missing{};
  /// Reported identity of each instrument of the rig, by its title ("chamber", "thermometer 2").
  std::map<std::string, std::string> identities{};
  /// Titles of the instruments of a real rig whose identity is that of a virtual instrument.
  std::vector<std::string> virtual_instruments{};
  drivers::ControllerSettings settings{};
  /// Warning if the chamber's air is far from all thermometers of a real rig (describe_air_mismatch()); may be empty.
  std::string air_mismatch{};
};
/// Returns the first set point, given the state in which the chamber was found. Fails if the run must not command the
/// chamber at all.
using Entrance = std::function<Result<Celsius>(const FoundChamber&)>;

class Rig {
 public:
  /// Makes a rig. Lines connect at their first use.
  [[nodiscard]] static Result<std::unique_ptr<Rig>> assemble(const RigFile& file, const RigStart& start);
  /// Makes a virtual rig on existing wires. `wires` must outlive it, and the world behind them may outlive many rigs.
  [[nodiscard]] static std::unique_ptr<Rig> assemble(const RigFile& file, Wires& wires);
  virtual ~Rig() = default;

  /// Queries and reads each instrument without moving anything. Returns one line each (inquiry.hpp), such as "chamber:
  /// Virtual chamber, air 20.01 °C, …", or the instrument's fault. On a real rig, the line of a virtual instrument
  /// contains SIMULATED.
  [[nodiscard]] virtual std::vector<Result<std::string>> query_instruments() = 0;
  /// Returns the range of set points that the chamber's controller accepts with its current settings.
  [[nodiscard]] virtual Result<drivers::SetPointRange> controller_limits() = 0;

  /// Prepares the rig for a run. Switches the power supplies as `RigStart::power` demands; a unit may be silent if its
  /// supply is off. Call it once, before the first sample; the run's clock starts at its end. Opens the
  /// gyros' lines and queries each instrument's identity. Calls `entrance` with the chamber as found, sends the chamber
  /// to the returned set point and starts it. Waits for the gyros' origin, which takes one second of the rig's time. If
  /// `program` is given, uploads it to the chamber's memory, compares it, and starts it last. Returns the identities of
  /// the instruments. Fails with the first fault: before the chamber has moved if chamber, thermometers or analogue
  /// inputs are silent, if a gyro's line is dead, or if `entrance` refuses; after that, the chamber is returned to the
  /// state in which it was found.
  [[nodiscard]] virtual Result<std::vector<std::string>> prepare(const Entrance& entrance,
                                                                 const drivers::ChamberProgram* program) = 0;
  [[nodiscard]] Result<std::vector<std::string>> prepare(Celsius first,
                                                         const drivers::ChamberProgram* program = nullptr) {
    return prepare([first](const FoundChamber&) -> Result<Celsius> { return first; }, program);
  }
  /// Returns true after a failed prepare() if nothing was moved, or everything was restored.
  [[nodiscard]] virtual bool is_as_found() const = 0;
  /// Returns the wall-clock time at which the run's clock will start: exact on a virtual rig before prepare(), the
  /// current time on a real one.
  [[nodiscard]] virtual Duration will_start_utc() const = 0;
  /// Advances a virtual rig's world and clock by whole seconds. Does nothing on a real rig.
  virtual void let_pass(std::int64_t seconds) = 0;
  /// Sets the state of the units under test of a virtual rig from the next second on. Does nothing on a real rig, where
  /// the operator does it.
  virtual void set_unit_state(const UnitState& state) = 0;

  [[nodiscard]] virtual const Clock& clock() const = 0;
  /// Returns the rig's InstrumentIo. Call it only after prepare().
  [[nodiscard]] virtual io::InstrumentIo& io() = 0;
  [[nodiscard]] virtual const RigFile& file() const = 0;
};

}  // namespace gyrotherm::rig
