// SPDX-License-Identifier: Apache-2.0
/// The documents that lie beside records: models, reports, calibrations.
#pragma once

#include <optional>
#include <string>

#include "apps/site/store.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// Reads a JSON file; nothing if it is no document of gyrotherm, by its schema. Fails with bad_file if it cannot be
/// read.
[[nodiscard]] Result<std::optional<Document>> read_document(const std::string& path);

}  // namespace gyrotherm::site
