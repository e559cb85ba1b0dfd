// SPDX-License-Identifier: Apache-2.0
/// Whether a record is as it was written: the chain over its rows, which shows an edit of one of them, and the manifest
/// over its files (RUN.db.sha256), which shows any other. All functions are for any thread, on a database of its own.
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

// The chain over a record's rows: each carries the beginning of a hash of itself and of the whole hash before it, so
// that a row that was changed, taken out, put in or moved no longer fits. It begins with what the run knew at its
// start. It makes edits evident, not impossible: who may write the file may also chain it anew.

class RowChain {
 public:
  RowChain() = default;
  explicit RowChain(const Digest& head) : head_(head) {}

  /// A row: begin(), each value in the order of its columns, end().
  void begin(std::string_view table);
  template <std::integral T>
  void add(T value) {
    add_integer(static_cast<std::int64_t>(value));
  }
  /// NaN is what the file has as NULL; a whole number is the same as an integer, as to the file.
  void add(double value);
  void add(std::string_view value);
  void add(std::monostate /*nothing*/) { row_ += 'n'; }
  /// What the row carries: the first 8 bytes of the hash that the next row continues.
  std::int64_t end();

  [[nodiscard]] const Digest& head() const { return head_; }

 private:
  void add_integer(std::int64_t value);
  void add_bits(char type, std::uint64_t bits);

  Digest head_{};
  std::string row_;
};

// The fingerprint of a closed run, RUN.db.sha256, in the form that `sha256sum -c` checks.

/// The digest of a file's bytes, in hexadecimal digits, read piece by piece: a record may be larger than what is read
/// at once. Fails with bad_file if it has more than `most` bytes, or as open_regular_file() does.
[[nodiscard]] Result<std::string> file_digest(const std::string& path,
                                              std::uint64_t most = std::numeric_limits<std::uint64_t>::max());

/// "RUN.db" → "RUN.db.sha256".
[[nodiscard]] std::string manifest_path(const std::string& record_path);

/// Writes the manifest of a record that consists of `files`, with logs that were left beside them. No connection to any
/// of them may be open in this process. Fails with storage.
[[nodiscard]] Result<void> write_manifest(const std::string& record_path, const std::vector<std::string>& files);

/// Files by name, each with its digest.
using Manifest = std::map<std::string, std::string>;
/// The files that agree with the manifest, which are all that it names; nothing if the record has none. A record that
/// was renamed, with all its files, is as it was: they have their new names here. Fails with bad_file naming the first
/// file that differs, or a log that lies beside a file and is not named.
[[nodiscard]] Result<std::optional<Manifest>> check_manifest(const std::string& record_path);

// Whether a record is as it was written, by its own chain.

/// The hash over what the run knew at its start, as the tables have it.
[[nodiscard]] Result<Digest> description_hash(Database& database);
/// The hash that a finished file ends with.
[[nodiscard]] Digest end_hash(RowChain chain, std::int64_t seen, std::int64_t lost, std::int64_t bad);

/// Calls `use` with each chained row of one open file in the order in which they were written: its table, the slot that
/// it belongs to, and its columns, the chain's own the last. Ends with the first fault.
using UseRow = std::function<Result<void>(std::string_view table, std::int64_t slot, const Statement& row)>;
[[nodiscard]] Result<void> each_chained_row(Database& database, const RunInfo& info, const UseRow& use);

struct CheckedChain {
  RowChain chain;  ///< to go on with
  std::int64_t rows{};
};

/// Walks along the chain of one open file. Fails with bad_file naming the first row that does not fit, or with storage.
[[nodiscard]] Result<CheckedChain> check_chain(Database& database, const std::string& path);

struct Verified {
  std::int64_t rows{};  ///< of every kind
  int files{};
  bool finished{};
  bool manifest{};       ///< there was one, and it agreed
  std::string digest{};  ///< then: of the record's first file
};

/// All files of a record: whether one is missing, their chains, then their bytes against the manifest, if the run was
/// closed with one. Fails with bad_file naming what is not as it was written; also if the record is not readable.
[[nodiscard]] Result<Verified> verify_files(const RecordFiles& files);

/// Also, of a run that was not closed, whether it holds all that its status file says was acknowledged. Fails likewise.
[[nodiscard]] Result<Verified> verify_record(const RecordFiles& files);
[[nodiscard]] Result<Verified> verify_record(const std::string& path);

/// Writes the manifest of a run whose last file was just finished. A record of several files is verified first, and has
/// none if it is not as it was written; fails then like verify_record(), otherwise with storage.
[[nodiscard]] Result<void> close_record(const std::string& path, int last_part);

}  // namespace gyrotherm::record
