// SPDX-License-Identifier: Apache-2.0
#include "apps/site/live/passfile.hpp"

#include <cstdlib>
#include <filesystem>

namespace gyrotherm::site {

std::string path_from(const std::string& file, const std::string& path) {
  return (std::filesystem::path(file).parent_path() / path).string();
}

std::string credentials_folder() {
  const char* folder = std::getenv("CREDENTIALS_DIRECTORY");
  return folder != nullptr ? folder : "";
}

std::string passfile_at(const TomlTable& table, const std::string& file, const std::string& credentials) {
  if (table.has("passfile") && table.has("credential"))
    table.mistake("credential", "has one of passfile and credential");
  if (table.has("credential")) {
    if (credentials.empty())
      table.mistake("credential", "there is no $CREDENTIALS_DIRECTORY: LoadCredential= of systemd makes it");
    return credentials + "/" + table.text("credential");
  }
  return table.has("passfile") ? path_from(file, table.text("passfile")) : "";
}

}  // namespace gyrotherm::site
