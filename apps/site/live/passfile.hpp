// SPDX-License-Identifier: Apache-2.0
/// Where a site file says that files lie, and passwords: the same for the store and for the broker. Any thread.
#pragma once

#include <string>

#include "core/toml_reader.hpp"

namespace gyrotherm::site {

/// A path of a site file, relative to the folder that the file lies in.
[[nodiscard]] std::string path_from(const std::string& file, const std::string& path);

/// $CREDENTIALS_DIRECTORY of systemd; empty where it gives none.
[[nodiscard]] std::string credentials_folder();

/// The file with a password: the table's `passfile`, or its `credential`, which lies in the folder `credentials`; empty
/// where it names neither. Mistakes are noted in the table.
[[nodiscard]] std::string passfile_at(const TomlTable& table, const std::string& file, const std::string& credentials);

}  // namespace gyrotherm::site
