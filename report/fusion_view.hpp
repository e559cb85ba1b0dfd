// SPDX-License-Identifier: Apache-2.0
/// The page of a fused record.
#pragma once

#include <string>

#include "analysis/model/fused_run.hpp"
#include "core/result.hpp"

namespace gyrotherm::report {

/// The fused rate of a record as one self-contained HTML page: its error against the Earth's rotation, or the rate
/// itself where that is not known; the parity and its limit; what was found and who was left out; what the Earth's
/// rotation says at rest.
[[nodiscard]] std::string html_of(const model::FusedRun& run, const std::string& program_version);

/// Writes `folder`/fusion.json, the summary, and `folder`/fusion.html, making the folder if needed; each file appears
/// whole or not at all. Fails with storage.
[[nodiscard]] Result<void> write_fusion(const model::FusedRun& run, const std::string& folder,
                                        const std::string& program_version);

}  // namespace gyrotherm::report
