/// Whether a record is as it was written, by its own chain.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "acquisition/record/row_chain.hpp"
#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"

namespace gyrotherm {

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
  bool manifest{};  ///< there was one, and it agreed
};

/// All files of a record: their chains, then their bytes against the manifest, if the run was closed with one. Fails
/// with bad_file naming what is not as it was written; also if the record is older than the chain, or not readable.
[[nodiscard]] Result<Verified> verify_files(const std::string& path);

/// Also, of a run that was not closed, whether it holds all that its status file says was acknowledged. Fails likewise.
[[nodiscard]] Result<Verified> verify_record(const std::string& path);

/// Writes the manifest of a run whose last file was just finished. A record of several files is verified first, and has
/// none if it is not as it was written; fails then like verify_record(), otherwise with storage.
[[nodiscard]] Result<void> close_record(const std::string& path, int last_part);

/// Whether the fault says that the record is of an older program, which made no chain: nothing is known to be wrong.
[[nodiscard]] bool is_unchained(const Fault& fault);

}  // namespace gyrotherm
