// SPDX-License-Identifier: Apache-2.0
/// Writes files that do not exist yet.
#pragma once

#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::app {

struct NewFile {
  std::string path;
  std::string text;
};

/// Returns the fault for a file that exists.
[[nodiscard]] tl::unexpected<Fault> refuse_to_overwrite(const std::string& path);

/// Writes all files, or none of them: on failure, the files that were already created are removed. Signals of this
/// thread are blocked meanwhile. Fails with usage if one of the files exists, and with storage if one cannot be
/// written.
[[nodiscard]] Result<void> create_files(const std::vector<NewFile>& files);

}  // namespace gyrotherm::app
