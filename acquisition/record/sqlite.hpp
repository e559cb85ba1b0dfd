// SPDX-License-Identifier: Apache-2.0
/// The few calls of SQLite that a record needs, owned, and failing with a Fault that names the file.
#pragma once

#include <sys/types.h>

#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace gyrotherm::record {

/// What one field of a row holds: nothing (NULL, as is NaN), a whole number, a number, or a text that outlives the row.
using Cell = std::variant<std::monostate, std::int64_t, double, std::string_view>;
[[nodiscard]] bool is_nothing(const Cell& cell);

/// One prepared statement. Parameters count from 1, columns from 0, as in SQLite.
class Statement {
 public:
  explicit Statement(sqlite3_stmt* statement = nullptr) : statement_(statement) {}

  template <std::integral T>
  void put(int parameter, T value) {
    put_integer(parameter, static_cast<std::int64_t>(value));
  }
  /// NaN is stored as NULL.
  void put(int parameter, double value);
  void put(int parameter, std::monostate nothing);
  /// The text must outlive the next run() or step().
  void put(int parameter, std::string_view value);

  /// Carries out a statement that returns no row, with the parameters put before, and makes it ready for the next.
  [[nodiscard]] Result<void> run();
  template <class... Values>
  requires(sizeof...(Values) > 0) [[nodiscard]] Result<void> run(const Values&... values) {
    int parameter = 0;
    (put(++parameter, values), ...);
    return run();
  }

  /// Goes to the next row; false after the last.
  [[nodiscard]] Result<bool> step();
  [[nodiscard]] int columns() const;
  [[nodiscard]] std::string name(int column) const;  ///< as the query has it
  [[nodiscard]] Cell cell(int column) const;         ///< whatever this row has there; a text as text() gives it
  [[nodiscard]] bool null(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double real(int column) const;            ///< NaN where NULL
  [[nodiscard]] std::string_view text(int column) const;  ///< valid until the next step

 private:
  struct Finalise {
    void operator()(sqlite3_stmt* statement) const;
  };
  void put_integer(int parameter, std::int64_t value);
  std::unique_ptr<sqlite3_stmt, Finalise> statement_;
};

/// read_only: nothing beside the file and nothing in it changes, not even a log that a dead writer left
/// (reader_vfs()). read_beside: a writer goes on writing it meanwhile, as it does with a live copy.
enum class Access { read_only, read_beside, read_write };

/// One connection to an existing file. Its statements must be gone before it is.
class Database {
 public:
  /// Opens the file; another program's lock is waited for at most `patience_ms`. Nothing is read yet, so a locked or
  /// foreign file fails at the first statement, of one that is only read already here: storage ("being written by
  /// another program") or bad_file. A file that this process writes is not opened to be read.
  [[nodiscard]] static Result<Database> open(const std::string& path, Access access, int patience_ms);

  [[nodiscard]] Result<void> execute(const std::string& sql);
  [[nodiscard]] Result<Statement> prepare(std::string_view sql);
  /// The query, standing at its first row; nothing if it has none.
  [[nodiscard]] Result<std::optional<Statement>> first_row(std::string_view sql);
  /// Calls `use` with each row of a query. Ends with the first fault, of the query or of `use`, where that returns one.
  template <class Use>
  [[nodiscard]] Result<void> each_row(std::string_view sql, Use use) {
    auto query = prepare(sql);
    if (!query) return failure(query.error());
    for (;;) {
      const auto more = query->step();
      if (!more) return failure(more.error());
      if (!*more) return {};
      if constexpr (std::is_void_v<std::invoke_result_t<Use&, const Statement&>>)
        use(*query);
      else if (auto used = use(*query); !used)
        return used;
    }
  }
  /// The first column of the first row, as text; empty if there is no row.
  [[nodiscard]] Result<std::string> ask(std::string_view sql);
  /// Likewise, as a whole number; `fallback` if there is no row or it is NULL.
  [[nodiscard]] Result<std::int64_t> ask_integer(std::string_view sql, std::int64_t fallback);

  /// The file's own path, with no link in it.
  [[nodiscard]] std::string path() const;
  [[nodiscard]] bool in_transaction() const;
  /// Counts from now on the pages of the write-ahead log, which SQLite then does not fold in by itself.
  void watch_log();
  /// As of the last commit, since watch_log().
  [[nodiscard]] int log_pages() const { return log_pages_ ? *log_pages_ : 0; }
  /// Copies the log into the file, so that it starts anew with the next commit.
  [[nodiscard]] Result<void> fold_log();
  /// Copies the log into a file that nobody else has open, and leaves none of it: what stays of one that was folded in
  /// would be taken for news after a crash, as far as it can still be read.
  [[nodiscard]] Result<void> empty_log();
  /// What it keeps of the file in memory is read anew from now on.
  void forget_pages();
  /// Closing leaves log and file as they are.
  void keep_log_on_close();

 private:
  struct Close {
    void operator()(sqlite3* connection) const;
  };
  explicit Database(sqlite3* connection) : connection_(connection) {}
  [[nodiscard]] Result<void> fold_log(int mode);
  std::unique_ptr<int> log_pages_;  ///< outlives the connection, which writes it
  std::unique_ptr<sqlite3, Close> connection_;
};

/// Puts what was read into its place.
template <class Place, class Value>
[[nodiscard]] Result<void> into(Place& place, Result<Value> read) {
  return std::move(read).map([&](Value value) { place = std::move(value); });
}

/// What a second program is told, also by itself in `Fault::what`.
inline constexpr const char* kBeingWritten = "being written by another program";

/// … and whoever wants to write what others read.
inline constexpr const char* kBeingRead = "being read by another program";

inline constexpr const char* kDiskFull = "the disk is full";

/// Whether the fault says that there is no space: nothing is lost, and the same file goes on once there is.
[[nodiscard]] bool is_full(const Fault& fault);

/// A path as SQLite is given it: what begins like one of its URIs or like a name that it keeps for memory is a file's
/// name too.
[[nodiscard]] std::string name_for_sqlite(const std::string& path);

/// Whether the fault says that another program holds the file.
[[nodiscard]] bool is_locked(const Fault& fault);

/// Whether somebody holds the file who reads it, and nobody who writes it. Not to be asked where this process has it
/// open to write it: that would lose its locks.
[[nodiscard]] bool is_being_read(const std::string& path);
/// Whether somebody holds the file who writes it, as this process may.
[[nodiscard]] bool is_being_written(const std::string& path);

// What makes SQLite keep its word: how a record's file is made, claimed and written so that a commit that has returned
// is on the disk.

/// How long a writer waits for another program's lock: a second program is told within a second.
inline constexpr int kWriterPatienceMs = 500;

/// An empty file that did not exist before, mode 0640; SQLite takes it for an empty database. Fails with storage.
[[nodiscard]] Result<void> make_new_file(const std::string& path);

/// Nobody else reads or writes the database until it is closed. Comes before make_durable(), so that the log's index
/// lives in memory and there is no file of it. All that follow fail with storage.
[[nodiscard]] Result<void> claim(Database& database, const std::string& path);
/// The way out of WAL mode leaves no journal behind for a reader to play back.
[[nodiscard]] Result<void> keep_no_journal(Database& database, const std::string& path);
/// A commit is on the disk when it returns; the log is folded in when the writer says so.
[[nodiscard]] Result<void> make_durable(Database& database, const std::string& path);

// The file system through which SQLite reads a record: it can read, and has no way to do anything else.
//
// A record may come from anywhere. SQLite's own file system plays back a journal that lies beside a file, deletes the
// journals that this one names, makes an index of a log, and folds a log in; this one opens files to read alone, makes
// and removes none, and shows no journal. A log beside the file is read where it lies, its index kept in memory.

/// Its name, for sqlite3_open_v2(); it is registered when it is first asked for. The connection must have
/// locking_mode EXCLUSIVE before its first statement. A file that a writer holds does not open (SQLITE_BUSY); while it
/// is open no writer can begin.
///
/// That is told by a lock of the open file itself (F_OFD_SETLK) on the bytes that SQLite locks (its "File Locking And
/// Concurrency"). Closing the file still drops the locks of a writer in this very process, as any close does: no record
/// may be opened that it writes (WrittenHere).
[[nodiscard]] const char* reader_vfs();

// Which records this process writes. SQLite's locks belong to the process, and the close of any other descriptor of
// the same file drops them all ("How To Corrupt", 2.2): so a record is never opened to be read where it is being
// written.

/// As long as it lives, the file that has this name now counts as written here. Any thread.
class WrittenHere {
 public:
  explicit WrittenHere(const std::string& path);
  ~WrittenHere();
  WrittenHere(const WrittenHere&) = delete;
  WrittenHere(WrittenHere&& other) noexcept : file_(std::exchange(other.file_, std::nullopt)) {}
  WrittenHere& operator=(WrittenHere&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }

 private:
  std::optional<std::pair<dev_t, ino_t>> file_;  ///< nothing: there was none
};

/// Nothing is opened to find that out. Any thread.
[[nodiscard]] bool is_written_here(const std::string& path);

}  // namespace gyrotherm::record
