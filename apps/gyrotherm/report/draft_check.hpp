// SPDX-License-Identifier: Apache-2.0
/// Comparison of a draft with the files from which it was made, before its authorisation.
#pragma once

#include <string>
#include <vector>

#include "apps/console/console.hpp"
#include "apps/gyrotherm/report/calibration.hpp"
#include "core/result.hpp"
#include "report/draft.hpp"
#include "report/order.hpp"
#include "report/report_files.hpp"

namespace gyrotherm::app {

/// Returns sources.json of a draft: the files of the command, relative to the folder of the draft.
[[nodiscard]] report::DraftSources name_sources(const CalibrationArguments& options, const std::string& folder,
                                                const std::string& unit, const std::string& calibration_sha256);

struct DraftCheckOptions {
  std::string folder;
  /// Laboratory file; empty: the one from which the draft was made.
  std::string laboratory;
  /// Further folders with the files from which the draft was made.
  std::vector<std::string> records;
  /// Accepts a draft although some of these files are missing.
  bool without_sources{};
};

struct CheckedDraft {
  report::LaboratoryFile laboratory{};
  bool sources_compared{};
};

/// Compares an unsigned report with its sources. Makes it again from records, models, order and laboratory file, which
/// must yield the same data. Fails with bad_file and names the keys that differ; also if the report contradicts itself,
/// or if its calibration.json is not the one that the program wrote. Fails with usage if sources are not found, unless
/// `without_sources` is set: then only the files that are found are compared, and the laboratory file is required.
[[nodiscard]] Result<CheckedDraft> check_draft(Console& console, const report::FiledReport& filed,
                                               const DraftCheckOptions& options);

}  // namespace gyrotherm::app
