// SPDX-License-Identifier: Apache-2.0
/// Content of a calibration report that comes from the record itself: unit, instruments, days and deviations.
#pragma once

#include <string>
#include <vector>

#include "acquisition/record/record.hpp"
#include "report/calibration.hpp"

namespace gyrotherm::app {

/// Record and its file.
struct SourceRecord {
  const record::Record& record;
  std::string name{};  ///< file name without folder
  std::string sha256{};
  bool chain_verified{};
  std::vector<report::UsedFile> parts{};
};

/// Adds the content that all axes of a unit share: the unit as named in the rig file; its instruments and the chamber,
/// with certificates (each once per calibration); the range of the air temperature; first and last day; files; and
/// deviations. Deviations are gaps, pauses, interlocks, channel faults (one line per channel and record, with their
/// number), notes and dropped units. Other units are ignored.
void add_record(report::CalibrationReport& report, const SourceRecord& source, const std::string& unit);

}  // namespace gyrotherm::app
