#include "acquisition/record/sqlite.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cassert>
#include <cstring>
#include <limits>

#include "acquisition/record/reader_vfs.hpp"
#include "acquisition/record/written_here.hpp"

namespace gyrotherm {
namespace {

constexpr int kLongestValue = 16'000'000;  ///< bytes of a text in a record that is read

Fault fault_of(sqlite3* connection) {
  const char* file = sqlite3_db_filename(connection, "main");
  const std::string where = file != nullptr ? file : "";
  switch (sqlite3_errcode(connection)) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED: return {FaultKind::storage, where, kBeingWritten};
    case SQLITE_NOTADB: return {FaultKind::bad_file, where, "not a gyrotherm record, expected a SQLite file"};
    case SQLITE_CORRUPT: return {FaultKind::storage, where, "the record is damaged"};
    case SQLITE_FULL: return {FaultKind::storage, where, kDiskFull};
    case SQLITE_IOERR:
      return {FaultKind::storage, where,
              fmt::format("{} (SQLite's code {})", sqlite3_errmsg(connection), sqlite3_extended_errcode(connection))};
    default: return {FaultKind::storage, where, sqlite3_errmsg(connection)};
  }
}

std::string why_not_opened(sqlite3* connection) {
  if (sqlite3_errcode(connection) != SQLITE_CANTOPEN || sqlite3_system_errno(connection) == 0)
    return sqlite3_errmsg(connection);
  return fmt::format("cannot be opened: {}", std::strerror(sqlite3_system_errno(connection)));
}

}  // namespace

bool is_full(const Fault& fault) { return fault.kind == FaultKind::storage && fault.what == kDiskFull; }

bool is_locked(const Fault& fault) { return fault.kind == FaultKind::storage && fault.what == kBeingWritten; }

void Statement::Finalise::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

void Statement::put_integer(int parameter, std::int64_t value) {
  [[maybe_unused]] const int code = sqlite3_bind_int64(statement_.get(), parameter, value);
  assert(code == SQLITE_OK);
}

void Statement::put(int parameter, double value) {
  [[maybe_unused]] const int code = sqlite3_bind_double(statement_.get(), parameter, value);
  assert(code == SQLITE_OK);
}

void Statement::put(int parameter, std::string_view value) {
  const char* bytes = value.data() != nullptr ? value.data() : "";
  [[maybe_unused]] const int code =
      sqlite3_bind_text64(statement_.get(), parameter, bytes, value.size(), SQLITE_STATIC, SQLITE_UTF8);
  assert(code == SQLITE_OK);
}

Result<void> Statement::run() {
  const int code = sqlite3_step(statement_.get());
  if (code != SQLITE_DONE) {
    const Fault fault = fault_of(sqlite3_db_handle(statement_.get()));
    sqlite3_reset(statement_.get());
    return failure(fault);
  }
  sqlite3_reset(statement_.get());
  return {};
}

Result<bool> Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return failure(fault_of(sqlite3_db_handle(statement_.get())));
}

int Statement::columns() const { return sqlite3_column_count(statement_.get()); }

ColumnType Statement::type(int column) const {
  switch (sqlite3_column_type(statement_.get(), column)) {
    case SQLITE_NULL: return ColumnType::null;
    case SQLITE_INTEGER: return ColumnType::integer;
    case SQLITE_FLOAT: return ColumnType::real;
    default: return ColumnType::text;
  }
}

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }

double Statement::real(int column) const {
  return null(column) ? std::numeric_limits<double>::quiet_NaN() : sqlite3_column_double(statement_.get(), column);
}

std::string_view Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

void Database::Close::operator()(sqlite3* connection) const {
  [[maybe_unused]] const int code = sqlite3_close(connection);
  assert(code == SQLITE_OK && "a statement outlived its database");
}

Result<Database> Database::open(const std::string& path, Access access, int patience_ms) {
  const bool reads = access == Access::read_only;
  if (reads && is_written_here(path)) return failure(FaultKind::storage, path, kBeingWritten);
  sqlite3* connection = nullptr;
  // A connection to read is used by one thread, and its statements lock nothing.
  const int flags = reads ? SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX : SQLITE_OPEN_READWRITE;
  const int code = sqlite3_open_v2(path.c_str(), &connection, flags, reads ? reader_vfs() : nullptr);
  Database database(connection);
  if (code == SQLITE_BUSY) return failure(FaultKind::storage, path, kBeingWritten);
  if (code != SQLITE_OK) return failure(FaultKind::bad_file, path, why_not_opened(connection));
  sqlite3_busy_timeout(connection, patience_ms);
  // A record may come from anywhere: its schema runs nothing, and a name in quotes is never taken for a text.
  sqlite3_db_config(connection, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(connection, SQLITE_DBCONFIG_DQS_DML, 0, nullptr);
  sqlite3_db_config(connection, SQLITE_DBCONFIG_DQS_DDL, 0, nullptr);
  sqlite3_db_config(connection, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  if (!reads) return database;
  sqlite3_limit(connection, SQLITE_LIMIT_LENGTH, kLongestValue);
  if (auto set =
          database.execute("PRAGMA locking_mode = EXCLUSIVE; PRAGMA temp_store = MEMORY; PRAGMA cell_size_check = ON");
      !set)
    return failure(set.error());
  database.keep_log_on_close();
  return database;
}

std::string Database::path() const {
  const char* name = sqlite3_db_filename(connection_.get(), "main");
  return name != nullptr ? name : "";
}

bool Database::in_transaction() const { return sqlite3_get_autocommit(connection_.get()) == 0; }

void Database::watch_log() {
  log_pages_ = std::make_unique<int>(0);
  const auto count = [](void* pages, sqlite3*, const char*, int now) {
    *static_cast<int*>(pages) = now;
    return SQLITE_OK;
  };
  sqlite3_wal_hook(connection_.get(), count, log_pages_.get());
}

Result<void> Database::fold_log() {
  const int code = sqlite3_wal_checkpoint_v2(connection_.get(), "main", SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
  if (code == SQLITE_OK) return {};
  return failure(fault_of(connection_.get()));
}

void Database::forget_pages() { sqlite3_db_release_memory(connection_.get()); }

void Database::keep_log_on_close() {
  sqlite3_db_config(connection_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
}

Result<void> Database::execute(const std::string& sql) {
  if (sqlite3_exec(connection_.get(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return failure(fault_of(connection_.get()));
}

Result<Statement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v3(connection_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (code != SQLITE_OK) return failure(fault_of(connection_.get()));
  return Statement(statement);
}

Result<std::string> Database::ask(std::string_view sql) {
  auto statement = prepare(sql);
  if (!statement) return failure(statement.error());
  const auto row = statement->step();
  if (!row) return failure(row.error());
  if (!*row) return std::string();
  std::string first(statement->text(0));
  // A statement that also writes has done so, or failed, only once it is stepped to its end.
  if (const auto more = statement->step(); !more) return failure(more.error());
  return first;
}

Result<std::int64_t> Database::ask_integer(std::string_view sql, std::int64_t fallback) {
  auto statement = prepare(sql);
  if (!statement) return failure(statement.error());
  const auto row = statement->step();
  if (!row) return failure(row.error());
  return *row && !statement->null(0) ? statement->integer(0) : fallback;
}

}  // namespace gyrotherm
