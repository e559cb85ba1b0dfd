// SPDX-License-Identifier: Apache-2.0
/// What the rig sees of an instrument, whatever its protocol.
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

/// Set points that a controller takes; nothing: it does not say.
struct SetPointRange {
  std::optional<Celsius> lowest, highest;
};

/// Answers who it is, and tells when another instrument may have taken its place.
class Identified {
 public:
  virtual ~Identified() = default;
  /// Returns make, model, serial number and the settings that change the meaning of its values, as far as the
  /// instrument reports them: the same words from the same instrument with the same settings. Empty: it cannot be
  /// asked. Fails with timeout, disconnected, refused or corrupted, and with mismatch if it is not the instrument that
  /// its description expects.
  [[nodiscard]] virtual Result<std::string> identify() = 0;
  /// Returns make, model and serial number alone, with which the words of identify() begin: enough for sending the safe
  /// set point to an instrument whose settings were changed. Fails like identify().
  [[nodiscard]] virtual Result<std::string> recognise() { return identify(); }
  /// Counts the connections that broke so far, those included that the driver made anew within one call.
  [[nodiscard]] virtual std::uint64_t breaks() const { return 0; }
};

/// Parts of an instrument's make, model and settings that identify() compared with its description, and parts that no
/// answer of it shows, in words.
struct IdentityReport {
  std::vector<std::string> verified, not_verified;
};

/// Settings of a controller on which its values depend (unit, decimals), by the name of the register, as last read.
using ControllerSettings = std::map<std::string, double>;

/// How long it takes to speak to a chamber, where that can be told.
struct ChamberEffort {
  int each_second = 0;    ///< exchanges for its air and set point, in each second
  int new_set_point = 0;  ///< … for a set point that is sent and read back
  int status = 0;         ///< … for all else that it says of itself, in turns
  Duration longest{};     ///< of an exchange, as seen lately
};

/// A temperature chamber that is driven by set points from the host, or carries out a program that the host gave it.
class Chamber : public Identified {
 public:
  /// Known after identify().
  [[nodiscard]] virtual IdentityReport verification() const { return {}; }
  /// One read of the air and of the set point that the controller holds, back within a second plus one exchange. What
  /// need not be read in each second is read in turn, as far as there is time.
  [[nodiscard]] virtual Result<ChamberState> read() = 0;
  /// The same with all that it says of itself, however long that takes: not within a tick.
  [[nodiscard]] virtual Result<ChamberState> inspect() { return read(); }
  /// Makes `target` the controller's set point: written, then read back within the register's resolution.
  /// Fails with timeout, disconnected, refused or mismatch; then the set point is unknown.
  [[nodiscard]] virtual Result<void> send_set_point(Celsius target) = 0;
  /// Starts conditioning at the present set point, verified by the state register where the map has one.
  [[nodiscard]] virtual Result<void> start() = 0;
  /// Ends conditioning, verified likewise.
  [[nodiscard]] virtual Result<void> stop() = 0;
  /// Zeros where nothing is known.
  [[nodiscard]] virtual ChamberEffort effort() const { return {}; }
  /// What of its state and alarms it says that it does not have, in words: nobody asks for that any more. Known after
  /// inspect().
  [[nodiscard]] virtual std::vector<std::string> missing() const { return {}; }
  /// Returns the settings as last read; empty where there are none, or none was read.
  [[nodiscard]] virtual ControllerSettings settings() const { return {}; }
  /// Carries out another command that the instrument knows: "acknowledge" (its alarms), "pause", "resume" (its own
  /// program), … Fails with refused where it knows none of that name.
  [[nodiscard]] virtual Result<void> perform(const std::string& command) {
    return failure(FaultKind::refused, "chamber " + command, "it has no such command");
  }
  /// The next call is tried at once, also on a line that rests after failures: for what cannot wait.
  virtual void end_rest() {}
  /// `target` as send_set_point() makes it, but at once, on a line that rests too, and with nothing asked that the
  /// write itself does not need: where a line loses answers, each question more is one that it may lose. Only a program
  /// that was started from here is ended before. From now on a unit or a number of decimals that cannot be read counts
  /// as it was last read. Fails like send_set_point().
  [[nodiscard]] virtual Result<void> send_set_point_at_once(Celsius target) {
    end_rest();
    return send_set_point(target);
  }
  /// Ends a program that the controller carries out, whoever started it; nothing to do where none runs, or the
  /// controller knows none.
  [[nodiscard]] virtual Result<void> end_program() { return {}; }
  /// What set points the controller takes, as it is set now.
  [[nodiscard]] virtual Result<SetPointRange> limits() { return SetPointRange{}; }

  /// Puts `program` into the controller's own memory and compares what it kept; says so in words. Nothing moves yet.
  [[nodiscard]] virtual Result<std::string> upload(const ChamberProgram& program) {
    (void)program;
    return failure(FaultKind::refused, "chamber upload", "it has no memory for programs");
  }
  /// Starts the program that was uploaded, from its first step, verified by the state register. send_set_point() ends
  /// it.
  [[nodiscard]] virtual Result<void> start_program() {
    return failure(FaultKind::refused, "chamber start_program", "it has no program");
  }
};

/// One instrument with one or more temperature inputs.
class Thermometer : public Identified {
 public:
  /// One reading per input, in the instrument's order. A silent instrument yields its fault in every place, an open or
  /// over-range input its own fault in its place.
  [[nodiscard]] virtual std::vector<Result<Celsius>> read() = 0;
};

/// One instrument with inputs for voltages and currents, which tell of gyros what their frames do not.
class AnalogueInputs : public Identified {
 public:
  /// One reading of each input that is used, in their order, each in the unit of measure that the instrument's
  /// description says; within a second plus one exchange. A silent instrument yields its fault in every place, an open
  /// or over-range input its own fault in its place.
  [[nodiscard]] virtual std::vector<Result<double>> read() = 0;
};

/// A gyro that sends frames by itself: of one axis or several, and of one unit under test or of several behind one
/// interface.
class Gyro : public Identified {
 public:
  /// A gyro that only sends cannot be asked. Called once it is open.
  [[nodiscard]] Result<std::string> identify() override { return std::string(); }
  /// Opens the line: what the gyro sends from now on can be read. Fails with disconnected. A gyro that needs no opening
  /// is open.
  [[nodiscard]] virtual Result<void> open() { return {}; }
  /// Waits for a first frame, from which read() counts on. Once, before the first read. Fails like read(). A gyro that
  /// counts from the start has nothing to wait for.
  [[nodiscard]] virtual Result<void> take_origin() { return {}; }
  /// What was counted since the last successful read, over the interval that the gyro's own clock measured, or the
  /// host's if it has none. Waits until `expected` of its time is covered, half of it by the host's, or the driver's
  /// limit is over. Fails with timeout, disconnected or corrupted: frames were lost, or the count begins anew here,
  /// after a silence or a broken line; what was counted meanwhile is unknown, and the next read counts from here. Fails
  /// with mismatch if the gyro is not set as its description says.
  [[nodiscard]] virtual Result<GyroCount> read(Duration expected) = 0;
  /// Frames of all reads so far. A gyro without frames has none.
  [[nodiscard]] virtual FrameCount frames() const { return {}; }
};

}  // namespace gyrotherm::drivers
