// SPDX-License-Identifier: Apache-2.0
/// The files of a report, which belong together and take their places together.
#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::report {

struct NewFile {
  std::string name, bytes;
};

/// Replaces files of a folder, in their order: the last is the one that makes the others valid. All are written under
/// names of their own before any takes its place, so that a full disk changes nothing. Fails with storage; a file that
/// comes later has then not been replaced.
[[nodiscard]] Result<void> replace_all(const std::string& folder, const std::vector<NewFile>& files);

}  // namespace gyrotherm::report
