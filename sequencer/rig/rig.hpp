// SPDX-License-Identifier: Apache-2.0
/// A rig assembled from its file: instruments on their lines, a io, a clock. Virtual and real rigs differ here and
/// nowhere else.
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
  std::uint16_t first_port = 0;  ///< 0: any free ones
  simulator::FramePace frames{};
  bool ptys = false;
  std::optional<Celsius> first_set_point{};  ///< of the profile that will be run; some rigs have stood there before
  bool attended = false;                     ///< see VirtualInstrumentsOptions
};
/// The virtual instruments of a rig file, serving on loopback (see VirtualInstrumentsOptions). In place of those of a
/// real rig with one axis stand virtual ones of the kinds, maps and streams that it names, in the world of the shipped
/// virtual rig; of other real rigs it fails with usage. Fails like parse_laboratory and VirtualInstruments::start.
[[nodiscard]] Result<std::unique_ptr<simulator::VirtualInstruments>> serve_virtual(const RigFile& file,
                                                                                   simulator::LaboratorySeed seed,
                                                                                   const ServeOptions& how = {});

/// How a rig comes to its first second.
struct RigStart {
  simulator::LaboratorySeed seed;  ///< virtual rig
  Duration already{};              ///< how long the run has lasted when its next second begins (resume)
  std::vector<simulator::PastSecond>
      replay;  ///< virtual rig: every second since it was switched on, but for the last one
  std::optional<Celsius> first_set_point{};  ///< virtual rig: of the profile
  bool units_may_be_off{};                   ///< their silence is no reason not to begin (resume)
  std::vector<std::string> dropped_units{};  ///< … nor that of these (resume)
};

/// The chamber's title among a rig's instruments.
inline constexpr const char* kChamberTitle = "chamber";

/// The chamber before anything of it was moved.
struct ChamberAsFound {
  ChamberState state;
  drivers::SetPointRange limits;       ///< as its controller is set
  std::vector<std::string> missing{};  ///< of what its state and alarms are read from, in words
  /// Who each instrument of the rig reports to be, by its title ("chamber", "thermometer 2").
  std::map<std::string, std::string> identities{};
  drivers::ControllerSettings settings{};
};
/// The set point that the chamber is to be sent to first, from where it stands; a fault is the reason why it may not be
/// moved at all.
using Entrance = std::function<Result<Celsius>(const ChamberAsFound&)>;

class Rig {
 public:
  /// Connects nothing yet: lines connect at first use.
  [[nodiscard]] static Result<std::unique_ptr<Rig>> assemble(const RigFile& file, const RigStart& start);
  /// A virtual rig on wires that are there already; `wires` outlives it, and the world behind them may outlive many
  /// rigs.
  [[nodiscard]] static std::unique_ptr<Rig> assemble(const RigFile& file, Wires& wires);
  virtual ~Rig() = default;

  /// Asks each instrument who it is and reads it a few times, moving nothing: one line each (inquiry.hpp), like
  /// "chamber: Virtual chamber, air 20.01 °C, …". A fault takes the place of an instrument that has one.
  [[nodiscard]] virtual std::vector<Result<std::string>> ask() = 0;
  /// What set points the chamber's controller takes, as it is set now.
  [[nodiscard]] virtual Result<drivers::SetPointRange> controller_limits() = 0;

  /// Opens the gyros' lines, asks each instrument who it is, and `entrance` whether the chamber, as it stands, may be
  /// moved, and to where; then sends the chamber there, starts it, and takes the gyros' origin, which takes a second of
  /// the rig's time. Once, before the first sample; a run's clock starts at its end. Fails with the first fault: before
  /// the chamber has been moved if chamber, thermometers or analogue inputs are silent, a gyro's line is dead, or
  /// `entrance` refuses; after that the chamber is put back to where it was found. Returns what the instruments say
  /// they are. `program`, if there is one, goes into the chamber's own memory, is compared and started: the last thing
  /// before the run's clock starts.
  [[nodiscard]] virtual Result<std::vector<std::string>> prepare(const Entrance& entrance,
                                                                 const drivers::ChamberProgram* program) = 0;
  [[nodiscard]] Result<std::vector<std::string>> prepare(Celsius first,
                                                         const drivers::ChamberProgram* program = nullptr) {
    return prepare([first](const ChamberAsFound&) -> Result<Celsius> { return first; }, program);
  }
  /// After a prepare() that failed: nothing was moved, or all of it has been put back.
  [[nodiscard]] virtual bool is_as_found() const = 0;
  /// When the run's clock will start, by the clock on the wall: before prepare() exactly on a virtual rig, on a real
  /// one as if it started now.
  [[nodiscard]] virtual Duration will_start_utc() const = 0;
  /// On a virtual rig lets the world and its clock move on by whole seconds; on a real one time passes by itself.
  virtual void let_pass(std::int64_t seconds) = 0;
  /// On a virtual rig brings the units under test to a state, from the next second on; on a real one people do.
  virtual void bring_units_to(const UnitState& state) = 0;

  [[nodiscard]] virtual const Clock& clock() const = 0;
  /// Only after prepare().
  [[nodiscard]] virtual io::InstrumentIo& io() = 0;
  [[nodiscard]] virtual const RigFile& file() const = 0;
};

}  // namespace gyrotherm::rig
