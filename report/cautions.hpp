// SPDX-License-Identifier: Apache-2.0
/// Cautions about the results of a model: its use outside the trained range, a missing improvement, and intervals that
/// do not hold. Cautions about records: a stop, an unknown zero of the bias, and failed sensors. Page, PDF and digital
/// certificate contain the same sentences.
#pragma once

#include <string>
#include <vector>

#include "report/calibration.hpp"
#include "report/words.hpp"

namespace gyrotherm::report {

/// Returns the cautions about one verification as sentences; empty if there is none. A record on which the model was
/// trained has its own mark and does not verify the model; for it, only the use outside the trained range counts.
[[nodiscard]] std::string describe_cautions(Language language, const ModelVerification& verification);

/// A caution about a record of the report.
struct RecordCaution {
  std::string run{}, text{};
};

/// Returns the cautions about the records: a stop before the end of the profile, a bias reference that is a mean of the
/// record, and warnings of an import, such as a failed thermometer.
[[nodiscard]] std::vector<RecordCaution> list_record_cautions(Language language, const CalibrationReport& report);

}  // namespace gyrotherm::report
