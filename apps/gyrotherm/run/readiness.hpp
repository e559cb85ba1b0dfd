// SPDX-License-Identifier: Apache-2.0
/// Checks of a rig before a run: lines of its instruments, calibrations, and the readiness list with its GO or NO-GO
/// verdict.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/gyrotherm/machine_checks.hpp"
#include "core/quantity.hpp"
#include "drivers/line/line_address.hpp"
#include "drivers/line/process_stream.hpp"
#include "sequencer/rig/rig_file.hpp"

namespace gyrotherm::app {

/// Instrument of a rig file and the line that it is connected to.
struct ConnectedInstrument {
  std::string title;
  std::string line;
  std::uint16_t usual_port = drivers::LineDefaults{}.port;
  /// Program that reads the instrument; its `words` are empty if there is none.
  drivers::ProgramCommand program{};
};

/// Lists the chamber, the thermometers, the gyros, the analogue inputs and the supplies, in this order.
[[nodiscard]] std::vector<ConnectedInstrument> instrument_lines(const rig::RigFile& rig);

/// Returns why the device name of a serial line may refer to another adapter tomorrow, with the name to use instead.
/// Returns an empty string for a stable name.
[[nodiscard]] std::string unstable_name(const std::string& line);

/// Returns a sentence for each calibration that is overdue on the day on which the rig would run.
[[nodiscard]] std::vector<std::string> list_overdue(const rig::RigFile& rig);

/// Returns a sentence for each proof test that is due or failed, and about the newest protocol.
[[nodiscard]] std::vector<std::string> list_due_proofs(const rig::RigFile& rig);

/// Fails with refused if the relay of [safe.also] is open or cannot be read, or if the rig file requires valid proof
/// tests ([policy] proof) and one is due or failed. Never fails for a virtual rig.
[[nodiscard]] Result<void> check_protection(const rig::RigFile& rig);

/// Reports the source of the bias reference. Warns if the Earth rate of an axis is unknown; the bias reference of that
/// axis is then the mean of the first hold.
[[nodiscard]] Finding check_bias_zero(const rig::RigFile& rig);

/// Checks the bias reference, the calibrations on the day of `utc`, the chamber's limiter, the disk of the record and
/// the watchdog. A virtual rig has neither limiter nor watchdog.
[[nodiscard]] std::vector<Finding> check_readiness(const rig::RigFile& rig, const std::string& record, Duration utc);

/// Prints the findings and the verdict: GO, GO WITH n WARNINGS or NO-GO. Prints only the warnings of a virtual rig.
void print_readiness(Console& console, const rig::RigFile& rig, const std::vector<Finding>& findings);

}  // namespace gyrotherm::app
