/// Puts the views of the report into a folder.
#pragma once

#include <string>

#include "core/result.hpp"

namespace gyrotherm {

/// Writes `folder`/report.json (the text as given), `folder`/report.html and `folder`/figures/*.svg, making the folders
/// if needed. Each file appears whole or not at all: it is written under a temporary name and renamed. Fails with
/// bad_file if the text is not a complete report (nothing is written then), or with storage.
[[nodiscard]] Result<void> write_report(const std::string& report_json_text, const std::string& folder);

/// The same from the report.json that is already in `folder`: `gyrotherm report DIR`. Fails also with storage if it
/// cannot be read.
[[nodiscard]] Result<void> rebuild_report(const std::string& folder);

}  // namespace gyrotherm
