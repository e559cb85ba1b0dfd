// SPDX-License-Identifier: Apache-2.0
/// What a record itself tells a calibration report: unit, instruments, days, and where the run was not as planned.
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/record.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::app {

/// A record and its file.
struct SourceRecord {
  const record::Record& record;
  std::string name{};    ///< of the file, without its folder
  std::string sha256{};  ///< of the file
  bool chain_verified{};
  std::vector<report::UsedFile> parts{};  ///< the files that it goes on in, by name and SHA-256
};

/// Adds what is the same for all axes of one unit: the unit as the rig file names it, its instruments and the chamber
/// with certificates (each once, and with each of its calibrations), the span of the chamber's air, days of the runs,
/// files, and deviations: gaps, pauses, interlocks, faults of a channel (one line a channel and record, with their
/// number), notes, units dropped. Of other units nothing is said.
void add_record(report::CalibrationReport& report, const SourceRecord& source, const std::string& unit);

}  // namespace gyrotherm::app
