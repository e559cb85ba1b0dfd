// SPDX-License-Identifier: Apache-2.0
/// Finds the files on which a report is based, and compares them with the report.
#pragma once

#include <string>
#include <vector>

#include "report/calibration.hpp"
#include "report/signed_report.hpp"

namespace gyrotherm::app {

/// Folders in which the files of a report are searched.
struct SearchFolders {
  std::string own{};                  ///< folder of the report; a file in it is never passed over
  std::vector<std::string> others{};  ///< folders given by the user, then the parent folder
  std::string distant{};              ///< folder above the parent: only a file with the right digest counts
};
[[nodiscard]] SearchFolders search_folders(const std::string& folder, const std::vector<std::string>& given);

/// Returns the file of the report: the one in its own folder, otherwise the first one with the right digest, otherwise
/// the first one in the other folders; empty if there is none. A profile, a rig and a column map are also found under
/// their name with ".toml". Ignores files that report::may_be_used_file() rejects; `all` are the files of the report. A
/// name may contain folders, but must not lead out of the searched folder.
[[nodiscard]] std::string find_used_file(const SearchFolders& folders, const report::UsedFile& file,
                                         const std::vector<report::UsedFile>& all);

/// Checks a file on which the report is based by its digest. A record is also verified against its hash chain, and
/// compared with the report: whether it is simulated, and the model and serial number of the unit. The digest of a
/// record may be that of the file or that of its rows.
[[nodiscard]] report::Check check_used_file(const SearchFolders& folders, const report::CalibrationReport& report,
                                            const report::UsedFile& file);

}  // namespace gyrotherm::app
