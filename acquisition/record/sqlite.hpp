// SPDX-License-Identifier: Apache-2.0
/// RAII wrappers for the few SQLite calls that a record needs. They fail with a Fault that names the file.
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

/// The value of a field: nothing (NULL or NaN), an integer, a real number, or a text that must outlive the row.
using Cell = std::variant<std::monostate, std::int64_t, double, std::string_view>;
/// Returns whether a cell has no value. NaN is not a value.
[[nodiscard]] bool is_null(const Cell& cell);

/// One prepared statement. Parameters count from 1, columns from 0, as in SQLite.
class Statement {
 public:
  explicit Statement(sqlite3_stmt* statement = nullptr) : statement_(statement) {}

  template <std::integral T>
  void put(int parameter, T value) {
    put_integer(parameter, static_cast<std::int64_t>(value));
  }
  /// Binds a number. NaN is stored as NULL.
  void put(int parameter, double value);
  void put(int parameter, std::monostate nothing);
  /// Binds a text, which must outlive the next run() or step().
  void put(int parameter, std::string_view value);

  /// Executes a statement without result rows with the bound parameters, and resets it for the next execution.
  [[nodiscard]] Result<void> run();
  template <class... Values>
  requires(sizeof...(Values) > 0) [[nodiscard]] Result<void> run(const Values&... values) {
    int parameter = 0;
    (put(++parameter, values), ...);
    return run();
  }

  /// Advances to the next row. Returns false after the last one.
  [[nodiscard]] Result<bool> step();
  [[nodiscard]] int columns() const;
  /// Returns the name of a column in the query.
  [[nodiscard]] std::string name(int column) const;
  /// Returns the value of a column with the type that the row stores. A text is valid until the next step().
  [[nodiscard]] Cell cell(int column) const;
  [[nodiscard]] bool null(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  /// Returns a number; NaN for NULL.
  [[nodiscard]] double real(int column) const;
  /// Returns a text, which is valid until the next step().
  [[nodiscard]] std::string_view text(int column) const;

 private:
  struct Finalise {
    void operator()(sqlite3_stmt* statement) const;
  };
  void put_integer(int parameter, std::int64_t value);
  std::unique_ptr<sqlite3_stmt, Finalise> statement_;
};

/// The purpose of a connection. read_only changes neither the file nor any file next to it, not even a log left
/// behind by a dead writer (reader_vfs()). read_beside reads a file that another program may be writing, such as a live
/// copy.
enum class Access { read_only, read_beside, read_write };

/// One connection to an existing file. Destroy its statements before the connection.
class Database {
 public:
  /// Opens the file, and waits at most `patience_ms` for the lock of another program. When opening for reading, fails
  /// with storage ("being written by another program") if the file is locked or this process is writing it, and with
  /// bad_file if the file has another format. With read_write the file is not read yet: if it is locked or has another
  /// format, the first statement fails instead.
  [[nodiscard]] static Result<Database> open(const std::string& path, Access access, int patience_ms);

  [[nodiscard]] Result<void> execute(const std::string& sql);
  [[nodiscard]] Result<Statement> prepare(std::string_view sql);
  /// Executes a query up to its first row. Returns nothing if there is no row.
  [[nodiscard]] Result<std::optional<Statement>> first_row(std::string_view sql);
  /// Calls `use` with each row of a query. Stops at the first fault of the query or, if `use` returns a Result, of
  /// `use`, and returns it.
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
  /// Returns the first column of the first row as text; empty if there is no row.
  [[nodiscard]] Result<std::string> query_text(std::string_view sql);
  /// Returns the first column of the first row as an integer; `fallback` if there is no row or it is NULL.
  [[nodiscard]] Result<std::int64_t> query_integer(std::string_view sql, std::int64_t fallback);

  /// Returns the file's path without symbolic links.
  [[nodiscard]] std::string path() const;
  [[nodiscard]] bool in_transaction() const;
  /// Starts to count the pages of the write-ahead log. SQLite no longer checkpoints the log automatically.
  void watch_log();
  /// Returns the number of pages in the log at the last commit; 0 if there was none since watch_log().
  [[nodiscard]] int log_pages() const { return log_pages_ ? *log_pages_ : 0; }
  /// Checkpoints the log: copies it into the file. The next commit then restarts the log.
  [[nodiscard]] Result<void> checkpoint_log();
  /// Checkpoints the log of a file that no other program has open, and truncates it. After a crash, SQLite would
  /// otherwise read the remains of a copied log as new data.
  [[nodiscard]] Result<void> empty_log();
  /// Drops the cached pages. The next access reads the file again.
  void forget_pages();
  /// Leaves the log and the file unchanged when the connection is closed.
  void keep_log_on_close();

 private:
  struct Close {
    void operator()(sqlite3* connection) const;
  };
  explicit Database(sqlite3* connection) : connection_(connection) {}
  [[nodiscard]] Result<void> checkpoint_log(int mode);
  std::unique_ptr<int> log_pages_;  ///< outlives the connection, which writes it
  std::unique_ptr<sqlite3, Close> connection_;
};

/// Moves the value of a result into `place`, or returns the fault of the result.
template <class Place, class Value>
[[nodiscard]] Result<void> assign_result(Place& place, Result<Value> read) {
  return std::move(read).map([&](Value value) { place = std::move(value); });
}

/// The message of a fault if another program is writing the file; also the complete `Fault::what`.
inline constexpr const char* kBeingWritten = "being written by another program";

/// The message of a fault if a program wants to write a file that another one is reading.
inline constexpr const char* kBeingRead = "being read by another program";

inline constexpr const char* kDiskFull = "the disk is full";

/// Returns whether the fault is a full disk. No data is lost, and the same file can be written again when there is
/// space.
[[nodiscard]] bool is_full(const Fault& fault);

/// Returns the path in a form that SQLite treats as a file name, even if it looks like an SQLite URI or like an
/// in-memory name.
[[nodiscard]] std::string name_for_sqlite(const std::string& path);

/// Returns whether the call failed because another program has locked the file.
[[nodiscard]] bool is_locked(const Fault& fault);

/// Returns whether another program is reading the file and none is writing it. Do not call it for a file that this
/// process has open for writing: the call would release its locks.
[[nodiscard]] bool is_being_read(const std::string& path);
/// Returns whether any program, including this one, is writing the file.
[[nodiscard]] bool is_being_written(const std::string& path);

// The settings and calls with which the file of a record is created, locked and written so that every commit is on the
// disk when it returns.

/// The time for which a writer waits for the lock of another program. A second program is refused within a second.
inline constexpr int kWriterPatienceMs = 500;

/// Creates an empty file with mode 0640, which SQLite opens as an empty database. Fails with storage, also if it
/// exists.
[[nodiscard]] Result<void> make_new_file(const std::string& path);

/// Locks the database exclusively until it is closed. Call it before make_durable(), so that the index of the log is in
/// memory and not in a file. This function and the following ones fail with storage.
[[nodiscard]] Result<void> lock_exclusively(Database& database, const std::string& path);
/// Keeps the journal in memory when WAL mode is left. A reader would otherwise roll back a journal file.
[[nodiscard]] Result<void> keep_journal_in_memory(Database& database, const std::string& path);
/// Enables WAL mode with settings that put a commit on the disk before it returns. The writer checkpoints the log
/// explicitly.
[[nodiscard]] Result<void> make_durable(Database& database, const std::string& path);

// The file system through which SQLite reads a record. It is read-only.
//
// A record may come from an untrusted source. SQLite's own file system rolls back a journal next to the file, deletes
// the journals that the journal names, creates the index of a log, and checkpoints a log. This file system opens files
// only for reading, creates and removes no files, and hides journals. It reads a log next to the file in place, and
// keeps the index of the log in memory.

/// Returns the name of this file system for sqlite3_open_v2(), and registers it at the first call. The connection must
/// have locking_mode EXCLUSIVE before its first statement. Opening a file fails with SQLITE_BUSY while a writer holds
/// it; while the file is open, no writer can begin.
///
/// The file is locked with an open file description lock (F_OFD_SETLK) on the bytes that SQLite locks (SQLite, "File
/// Locking And Concurrency"). Closing the file still releases the locks of a writer in this process, as any close does.
/// A record that this process writes must therefore not be opened (WrittenHere).
[[nodiscard]] const char* reader_vfs();

// The records that this process writes. SQLite's locks belong to the process, and closing any other descriptor of the
// same file releases all of them (SQLite, "How To Corrupt", 2.2). A record is therefore never opened for reading while
// this process writes it.

/// Registers the file that has this name now as written by this process, until destruction. Any thread.
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
  /// Not set if there was no file.
  std::optional<std::pair<dev_t, ino_t>> file_;
};

/// Returns whether this process writes the file. Opens no file. Any thread.
[[nodiscard]] bool is_written_by_this_process(const std::string& path);

}  // namespace gyrotherm::record
