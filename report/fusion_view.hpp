// SPDX-License-Identifier: Apache-2.0
/// The page of a fused record.
#pragma once

#include <string>

#include "analysis/model/fused_run.hpp"
#include "core/result.hpp"

namespace gyrotherm::report {

/// Returns the fused rate of a record as a self-contained HTML page: the error against the Earth rate, or the rate
/// itself if the Earth rate is unknown; the parity statistic and its limit; alarms and excluded axes; and the Earth
/// rate measured at rest.
[[nodiscard]] std::string to_html(const model::FusedRun& run, const std::string& program_version);

/// Writes the summary `folder`/fusion.json and the page `folder`/fusion.html. Creates the folder if needed. Each file
/// appears completely or not at all. Fails with storage.
[[nodiscard]] Result<void> write_fusion(const model::FusedRun& run, const std::string& folder,
                                        const std::string& program_version);

}  // namespace gyrotherm::report
