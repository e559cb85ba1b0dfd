// SPDX-License-Identifier: Apache-2.0
/// What the rows of closed records hash to, kept in the folder of an experiment, so that who comes again, or works on
/// one axis of many, need not read every row of every unit once more.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::app {

/// FOLDER/digests.json.
class KnownDigests {
 public:
  /// Those that were remembered in the folder by this version of the program: none where there is no such file, or one
  /// that says something else.
  KnownDigests(const std::string& folder, std::string program_version);

  /// The digest of the record's rows as `export` writes them, if its files are, byte by byte, those of which it was
  /// made; the record is then as it was written. Fails with bad_file if they are not what its manifest says.
  [[nodiscard]] Result<std::optional<std::string>> of_rows(const std::string& record_path) const;

  /// A record that is not closed is not remembered. Fails likewise, or with storage.
  [[nodiscard]] Result<void> remember(const std::string& record_path, const std::string& rows);

  struct Entry {
    std::vector<std::pair<std::string, std::string>> files{};  ///< of the record by name, each with its digest
    std::string rows{};
  };

 private:
  std::string path_, program_version_;
  std::vector<Entry> entries_;
};

}  // namespace gyrotherm::app
