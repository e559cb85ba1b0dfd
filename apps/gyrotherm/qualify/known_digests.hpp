// SPDX-License-Identifier: Apache-2.0
/// Digests of the rows of closed records, stored in the folder of an experiment. They save a second call of `qualify`,
/// or the training of a single axis, from reading every row of every unit.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::app {

/// Caches the digests of verified records in FOLDER/digests.json, so unchanged records are not read again. The
/// functions may be called from any thread.
class KnownDigests {
 public:
  /// Reads the digests that this version of the program stored in the folder. Starts empty if the file is missing or
  /// has another format or version.
  KnownDigests(const std::string& folder, std::string program_version);

  /// Digests of a record: of its file, and of its rows as `export` writes them.
  struct Digests {
    std::string file{}, rows{};
  };

  /// Returns the stored digests of a record, or nothing if none are stored for exactly the present bytes of the
  /// record's files. Fails with bad_file if a file contradicts the record's manifest.
  [[nodiscard]] Result<std::optional<Digests>> find(const std::string& record_path) const;

  /// Stores the digest of the rows of a closed record and returns the digest of its file. Ignores a record that is not
  /// closed and returns an empty text. Fails like find(), or with storage.
  [[nodiscard]] Result<std::string> store_rows(const std::string& record_path, const std::string& rows);

  struct Entry {
    std::vector<std::pair<std::string, std::string>> files{};  ///< name and digest of each file
    std::string rows{};
  };

 private:
  [[nodiscard]] bool is_empty() const;

  std::string path_, program_version_;
  mutable std::mutex guard_;  ///< guards entries_ and the file
  std::vector<Entry> entries_;
};

}  // namespace gyrotherm::app
