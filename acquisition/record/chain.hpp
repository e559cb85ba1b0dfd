// SPDX-License-Identifier: Apache-2.0
/// Verifies that a record is unchanged. The hash chain over the rows detects edited rows. The manifest of the record's
/// files (RUN.db.sha256) detects any other change. Any thread may call these functions, with a database of its own.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::record {

// The hash chain over the rows of a record. Each row stores the first bytes of a hash over the row and the complete
// previous hash. If a row was changed, removed, inserted or moved, the hashes no longer match. The chain starts with
// the hash of the run's description at its start. The chain makes edits evident but does not prevent them: anyone who
// can write the file can also recompute the chain.

class RowChain {
 public:
  RowChain() = default;
  explicit RowChain(const Digest& head) : head_(head) {}

  /// Starts a row. For each row, call begin(), then add() for each value in the order of the columns, then end().
  void begin(std::string_view table);
  template <std::integral T>
  void add(T value) {
    add_integer(static_cast<std::int64_t>(value));
  }
  /// Adds a number. Treats NaN as NULL and a whole number as an integer, because the file stores them like this.
  void add(double value);
  void add(std::string_view value);
  void add(std::monostate /*nothing*/) { row_ += 'n'; }
  /// Returns the value that the row stores: the first 8 bytes of its hash. The chain continues from the complete hash.
  std::int64_t end();

  [[nodiscard]] const Digest& head() const { return head_; }

 private:
  void add_integer(std::int64_t value);
  void add_bits(char type, std::uint64_t bits);

  Digest head_{};
  std::string row_;
};

/// Adds a segment to the row that was begun: the row of a decision also covers the segments that the decision adds.
void chain_segment(RowChain& chain, std::size_t position, const RunInfo::SegmentInfo& segment);

// The manifest of a closed run, RUN.db.sha256. It has the format that `sha256sum -c` checks.

/// Returns the digest of a file's bytes in hexadecimal digits. Reads the file in pieces, so its size is not limited by
/// memory. Fails with bad_file if the file has more than `most` bytes, or as open_regular_file() does.
[[nodiscard]] Result<std::string> file_digest(const std::string& path,
                                              std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

/// Returns the path of a record's manifest: "RUN.db.sha256" for "RUN.db".
[[nodiscard]] std::string manifest_path(const std::string& record_path);

/// Writes the manifest of a record that consists of `files`, including write-ahead logs next to them. This process must
/// have no open connection to any of them. Fails with storage.
[[nodiscard]] Result<void> write_manifest(const std::string& record_path, const std::vector<std::string>& files);

/// Digest of each file, by file name.
using Manifest = std::map<std::string, std::string>;
/// Compares the files with the manifest and returns the manifest, or nothing if the record has none. A record that was
/// renamed together with all its files is unchanged, and the result has the new names. Fails with bad_file, naming the
/// first file that differs or a log that the manifest does not list.
[[nodiscard]] Result<std::optional<Manifest>> check_manifest(const std::string& record_path);

// Verification of a record by its own chain.

/// Returns the hash over the description of the run in the tables. Excludes the outcome, which is written at the end,
/// and the segments that decisions have added since.
[[nodiscard]] Result<Digest> description_hash(Database& database);
/// Returns the final hash of a finished file, which covers the chain and the frame counts.
[[nodiscard]] Digest end_hash(RowChain chain, std::int64_t seen, std::int64_t lost, std::int64_t bad);

/// Calls `use` with each chained row of one open file, in the order of writing. Passes the table, the slot of the row
/// and its columns. The last column is the stored link of the chain. Stops at the first fault and returns it.
using UseRow = std::function<Result<void>(std::string_view table, std::int64_t slot, const Statement& row)>;
[[nodiscard]] Result<void> each_chained_row(Database& database, const RunInfo& info, const UseRow& use);

struct CheckedChain {
  /// The chain after the last row; new rows continue it.
  RowChain chain;
  std::int64_t rows{};
};

/// Verifies the chain of one open file. Fails with bad_file, naming the first row that does not match, or with storage.
[[nodiscard]] Result<CheckedChain> check_chain(Database& database, const std::string& path);

struct Verified {
  std::int64_t rows{};  ///< rows of all kinds
  int files{};
  bool finished{};
  /// True if the record has a manifest. It then matches the files.
  bool manifest{};
  /// The digest of the record's first file, if there is a manifest.
  std::string digest{};
};

/// Verifies that no file of a record is missing, that the chain of each file matches, and that the manifest matches if
/// the record has one. Fails with bad_file, naming the part that was changed or cannot be read.
[[nodiscard]] Result<Verified> verify_files(const RecordFiles& files);

/// Verifies the files and compares the end of an unfinished run with its status file: every second acknowledged there
/// must be present. Fails as verify_files() does.
[[nodiscard]] Result<Verified> verify_record(const RecordFiles& files);
[[nodiscard]] Result<Verified> verify_record(const std::string& path);

/// Writes the manifest of a run after its last file was finished. Verifies a record of several files first, and writes
/// no manifest if that fails. Fails as verify_record() does, or with storage.
[[nodiscard]] Result<void> close_record(const std::string& path, int last_part);

}  // namespace gyrotherm::record
