/// The few calls of SQLite that a record needs, owned, and failing with a Fault that names the file.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace gyrotherm {

enum class ColumnType { null, integer, real, text };

/// One prepared statement. Parameters count from 1, columns from 0, as in SQLite.
class Statement {
 public:
  explicit Statement(sqlite3_stmt* statement) : statement_(statement) {}

  template <std::integral T>
  void put(int parameter, T value) {
    put_integer(parameter, static_cast<std::int64_t>(value));
  }
  /// NaN is stored as NULL.
  void put(int parameter, double value);
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
  [[nodiscard]] ColumnType type(int column) const;  ///< of this row's value
  [[nodiscard]] bool null(int column) const { return type(column) == ColumnType::null; }
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
/// (reader_vfs.hpp).
enum class Access { read_only, read_write };

/// One connection to an existing file. Its statements must be gone before it is.
class Database {
 public:
  /// Opens the file; another program's lock is waited for at most `patience_ms`. Nothing is read yet, so a locked or
  /// foreign file fails at the first statement, of one that is only read already here: storage ("being written by
  /// another program") or bad_file. A file that this process writes is not opened to be read.
  [[nodiscard]] static Result<Database> open(const std::string& path, Access access, int patience_ms);

  [[nodiscard]] Result<void> execute(const std::string& sql);
  [[nodiscard]] Result<Statement> prepare(std::string_view sql);
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
  /// Copies the log into the file, so that it starts anew.
  [[nodiscard]] Result<void> fold_log();
  /// What it keeps of the file in memory is read anew from now on.
  void forget_pages();
  /// Closing leaves log and file as they are.
  void keep_log_on_close();

 private:
  struct Close {
    void operator()(sqlite3* connection) const;
  };
  explicit Database(sqlite3* connection) : connection_(connection) {}
  std::unique_ptr<int> log_pages_;  ///< outlives the connection, which writes it
  std::unique_ptr<sqlite3, Close> connection_;
};

/// What a second program is told, also by itself in `Fault::what`.
inline constexpr const char* kBeingWritten = "being written by another program";

inline constexpr const char* kDiskFull = "the disk is full";

/// Whether the fault says that there is no space: nothing is lost, and the same file goes on once there is.
[[nodiscard]] bool is_full(const Fault& fault);

/// Whether the fault says that another program holds the file.
[[nodiscard]] bool is_locked(const Fault& fault);

}  // namespace gyrotherm
