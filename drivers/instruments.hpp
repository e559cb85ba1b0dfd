// SPDX-License-Identifier: Apache-2.0
/// Interfaces of the instruments, independent of their protocols.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm::drivers {

struct ChamberProgram;  // drivers/chamber/program.hpp

/// Range of set points that a controller accepts. A limit is empty if the controller does not report it.
struct SetPointRange {
  std::optional<Celsius> lowest, highest;
};

/// An instrument that can be identified and that counts broken connections, after which another instrument may answer.
class Identified {
 public:
  virtual ~Identified() = default;
  /// Returns make, model, serial number and the settings that change the meaning of the instrument's values, as far as
  /// the instrument reports them. The text is always equal for the same instrument with the same settings; it is empty
  /// if the instrument cannot be queried. Fails with timeout, disconnected, refused or corrupted, and with mismatch if
  /// the instrument differs from its description.
  [[nodiscard]] virtual Result<std::string> identify() = 0;
  /// Returns only make, model and serial number, the start of the text that identify() returns. They suffice to send
  /// the safe set point to an instrument whose settings were changed. Fails as identify() does.
  [[nodiscard]] virtual Result<std::string> recognise() { return identify(); }
  /// Returns the number of connections that broke so far, including connections that the driver replaced within one
  /// call.
  [[nodiscard]] virtual std::uint64_t breaks() const { return 0; }
};

/// Properties in an instrument's description, as text. identify() compared those in `verified` with the instrument's
/// answers; no answer contains those in `not_verified`.
struct IdentityReport {
  std::vector<std::string> verified, not_verified;
};

/// Latest settings of a controller that determine the meaning of its values (unit, decimals), keyed by register name.
using ControllerSettings = std::map<std::string, double>;

/// Number and duration of a driver's exchanges with a chamber; 0 if unknown.
struct ChamberEffort {
  /// Exchanges per second for air temperature and set point.
  int each_second = 0;
  /// Exchanges for a set point that is sent and read back.
  int new_set_point = 0;
  /// Exchanges for all other status values, which are read in turn.
  int status = 0;
  Duration longest{};  ///< longest recent exchange
};

/// A temperature chamber. The host sends set points, or uploads a program that the chamber's controller executes.
class Chamber : public Identified {
 public:
  /// Returns the report of the latest identify().
  [[nodiscard]] virtual IdentityReport verification() const { return {}; }
  /// Reads the air temperature and the controller's set point once, within one second plus one exchange. In the
  /// remaining time, reads status values in turn.
  [[nodiscard]] virtual Result<ChamberState> read() = 0;
  /// Reads as read() does, but including all status values, regardless of the time required. Not for use within a tick.
  [[nodiscard]] virtual Result<ChamberState> inspect() { return read(); }
  /// Writes `target` as the controller's set point and reads it back; both must agree within the register's resolution.
  /// Fails with timeout, disconnected, refused or mismatch; the controller's set point is unknown afterwards.
  [[nodiscard]] virtual Result<void> send_set_point(Celsius target) = 0;
  /// Starts temperature control at the present set point, and verifies it by the state register if the map has one.
  [[nodiscard]] virtual Result<void> start() = 0;
  /// Stops temperature control, verified as in start().
  [[nodiscard]] virtual Result<void> stop() = 0;
  /// Returns the exchanges that the driver needs.
  [[nodiscard]] virtual ChamberEffort effort() const { return {}; }
  /// Returns the status values and alarms that do not exist in the controller and are therefore no longer read. The
  /// list is complete after inspect().
  [[nodiscard]] virtual std::vector<std::string> missing() const { return {}; }
  /// Returns the values that the latest status has if none of the map's states fits them: "mode \"AUTO\"". Empty if one
  /// fits, or if the map has no states.
  [[nodiscard]] virtual std::string unmatched_state() const { return {}; }
  /// Returns the settings that were read last. Empty if the controller has none or none was read.
  [[nodiscard]] virtual ControllerSettings settings() const { return {}; }
  /// Executes another command of the instrument: "acknowledge" (its alarms), "pause", "resume" (its program), … Fails
  /// with refused if the instrument has no such command.
  [[nodiscard]] virtual Result<void> perform(const std::string& command) {
    return failure(FaultKind::refused, "chamber " + command, "not supported by this chamber");
  }
  /// Makes the next call try immediately, even if the connection is in its rest period after failures. For urgent
  /// commands.
  virtual void end_rest() {}
  /// Sends a set point as send_set_point() does, but immediately, and without queries that the write itself does not
  /// need, because every query may be lost on a bad line. Ignores the rest period after failures. Ends a program only
  /// if this process started it, the latest status reports one, or the controller refuses the write. From now on, if a
  /// unit or number of decimals cannot be read, its latest value is used. Fails as send_set_point() does.
  [[nodiscard]] virtual Result<void> send_set_point_immediately(Celsius target) {
    end_rest();
    return send_set_point(target);
  }
  /// Sends the commands of the safe state to a chamber whose answers cannot be understood: the preparation, the set
  /// point `target`, and if `off` the stop. No answer is evaluated, so success means only that the commands were sent.
  /// Call it only for a chamber that was identified before. Fails with refused if the commands cannot be formed without
  /// reading, and with disconnected if nothing can be sent, or if another unit answered the last query of the identity.
  [[nodiscard]] virtual Result<void> send_safe_state_unconfirmed(Celsius target, bool off) {
    (void)target, (void)off;
    return failure(FaultKind::refused, "chamber", "not supported by this chamber");
  }
  /// Ends the program that the controller is executing, even one started at its panel. Does nothing if no program is
  /// running or the controller has no programs.
  [[nodiscard]] virtual Result<void> end_program() { return {}; }
  /// Returns the set points that the controller accepts under its present settings.
  [[nodiscard]] virtual Result<SetPointRange> limits() { return SetPointRange{}; }

  /// Stores `program` in the controller's memory and compares the stored program with it. Returns a summary for people.
  /// Nothing is started.
  [[nodiscard]] virtual Result<std::string> upload(const ChamberProgram& program) {
    (void)program;
    return failure(FaultKind::refused, "chamber upload", "this chamber cannot store programs");
  }
  /// Starts the uploaded program at its first step, verified by the state register. send_set_point() ends it.
  [[nodiscard]] virtual Result<void> start_program() {
    return failure(FaultKind::refused, "chamber start_program", "this chamber has no programs");
  }
};

/// One instrument with one or more temperature inputs.
class Thermometer : public Identified {
 public:
  /// Returns one reading per input, in the instrument's order. If the instrument does not answer, every reading is the
  /// fault of the exchange. An open or over-range input has its own fault.
  [[nodiscard]] virtual std::vector<Result<Celsius>> read() = 0;
};

/// An instrument with inputs for voltages and currents, which measures values of a gyro that its frames do not contain.
class AnalogueInputs : public Identified {
 public:
  /// Returns one reading per configured input, in their order, within one second plus one exchange. The unit of a
  /// reading is specified in the instrument's description. Faults are reported as by Thermometer::read().
  [[nodiscard]] virtual std::vector<Result<double>> read() = 0;
};

/// A gyro interface that sends frames without being queried. It may have several axes, and may serve several units
/// under test.
class Gyro : public Identified {
 public:
  /// Returns an empty text, because a gyro that only sends cannot be queried. Called once the line is open.
  [[nodiscard]] Result<std::string> identify() override { return std::string(); }
  /// Opens the line; frames sent from now on can be read. Fails with disconnected. The default does nothing.
  [[nodiscard]] virtual Result<void> open() { return {}; }
  /// Waits for the first frame, which is the origin of the count. Called once, before the first read(). Fails as read()
  /// does. The default does nothing.
  [[nodiscard]] virtual Result<void> wait_for_origin() { return {}; }
  /// Returns the pulses since the last successful read, and the interval in which they were counted. The interval is
  /// measured by the gyro's own clock, or by the host's clock if the gyro has none. Waits until `expected` of the
  /// gyro's time has passed (at least half of it by the host's clock), or until the driver's limit. Fails with timeout,
  /// disconnected or corrupted if frames were lost, or if the count starts again after a silence or a broken line. The
  /// pulses since the last successful read are then unknown, and the next read counts from the new start. Fails with
  /// mismatch if the gyro's settings differ from its description.
  [[nodiscard]] virtual Result<GyroCount> read(Duration expected) = 0;
  /// Returns the frame counts of all reads so far; zero for a gyro without frames.
  [[nodiscard]] virtual FrameCount frames() const { return {}; }
};

}  // namespace gyrotherm::drivers
