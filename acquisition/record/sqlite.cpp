// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/sqlite.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <set>

#include "acquisition/record/store.hpp"
#include "core/file.hpp"

namespace gyrotherm::record {

namespace {

/// The maximum size in bytes of a value in a record that is read.
constexpr int kLongestValue = 16'000'000;

/// Returns whether a file has the name of a table of another program.
bool is_table_name(std::string_view path) {
  return path.ends_with(".csv") || path.ends_with(".tsv") || path.ends_with(".txt") || path.ends_with(".log");
}

Fault last_fault(sqlite3* connection) {
  const char* file = sqlite3_db_filename(connection, "main");
  const std::string where = file != nullptr ? file : "";
  switch (sqlite3_errcode(connection)) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED: return {FaultKind::storage, where, kBeingWritten};
    case SQLITE_NOTADB:
      return {FaultKind::bad_file, where,
              fmt::format("not a gyrotherm record, expected a SQLite file{}",
                          is_table_name(where) ? "; \"gyrotherm import\" makes a record of a table" : "")};
    case SQLITE_CORRUPT: return {FaultKind::storage, where, "the record is damaged"};
    case SQLITE_FULL: return {FaultKind::storage, where, kDiskFull};
    case SQLITE_IOERR:
      return {FaultKind::storage, where,
              fmt::format("{} (SQLite code {})", sqlite3_errmsg(connection), sqlite3_extended_errcode(connection))};
    default: return {FaultKind::storage, where, sqlite3_errmsg(connection)};
  }
}

std::string open_error(sqlite3* connection) {
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

void Statement::put(int parameter, std::monostate /*nothing*/) { sqlite3_bind_null(statement_.get(), parameter); }

void Statement::put(int parameter, std::string_view value) {
  const char* bytes = value.data() != nullptr ? value.data() : "";
  [[maybe_unused]] const int code =
      sqlite3_bind_text64(statement_.get(), parameter, bytes, value.size(), SQLITE_STATIC, SQLITE_UTF8);
  assert(code == SQLITE_OK);
}

Result<void> Statement::run() {
  const int code = sqlite3_step(statement_.get());
  if (code != SQLITE_DONE) {
    const Fault fault = last_fault(sqlite3_db_handle(statement_.get()));
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
  return failure(last_fault(sqlite3_db_handle(statement_.get())));
}

int Statement::columns() const { return sqlite3_column_count(statement_.get()); }

std::string Statement::name(int column) const { return sqlite3_column_name(statement_.get(), column); }

Cell Statement::cell(int column) const {
  switch (sqlite3_column_type(statement_.get(), column)) {
    case SQLITE_NULL: return {};
    case SQLITE_INTEGER: return integer(column);
    case SQLITE_FLOAT: return real(column);
    default: return text(column);
  }
}
bool Statement::null(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }

double Statement::real(int column) const {
  return null(column) ? std::numeric_limits<double>::quiet_NaN() : sqlite3_column_double(statement_.get(), column);
}

std::string_view Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  if (bytes == nullptr) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

bool is_null(const Cell& cell) {
  const double* number = std::get_if<double>(&cell);
  return number != nullptr ? std::isnan(*number) : std::holds_alternative<std::monostate>(cell);
}

void Database::Close::operator()(sqlite3* connection) const {
  [[maybe_unused]] const int code = sqlite3_close(connection);
  assert(code == SQLITE_OK && "a statement outlived its database");
}

std::string name_for_sqlite(const std::string& path) {
  return path.starts_with("file:") || path.starts_with(':') ? "./" + path : path;
}

Result<Database> Database::open(const std::string& path, Access access, int patience_ms) {
  const bool reads = access != Access::read_write;
  const bool beside = access == Access::read_beside;
  if (reads && is_written_by_this_process(path)) return failure(FaultKind::storage, path, kBeingWritten);
  sqlite3* connection = nullptr;
  // Every connection is used by one thread at a time, so it needs no mutex.
  const int flags = SQLITE_OPEN_NOMUTEX | (reads ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE);
  const auto name = path == kInMemory && !reads ? path : name_for_sqlite(path);
  const int code = sqlite3_open_v2(name.c_str(), &connection, flags, reads && !beside ? reader_vfs() : nullptr);
  Database database(connection);
  if (code == SQLITE_BUSY) return failure(FaultKind::storage, path, kBeingWritten);
  if (code != SQLITE_OK) return failure(FaultKind::bad_file, path, open_error(connection));
  sqlite3_busy_timeout(connection, patience_ms);
  // Treat the file as untrusted: its schema runs no functions, and a quoted name is never read as a text.
  sqlite3_db_config(connection, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(connection, SQLITE_DBCONFIG_DQS_DML, 0, nullptr);
  sqlite3_db_config(connection, SQLITE_DBCONFIG_DQS_DDL, 0, nullptr);
  sqlite3_db_config(connection, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  if (!reads) return database;
  sqlite3_limit(connection, SQLITE_LIMIT_LENGTH, kLongestValue);
  const auto* locking = beside ? "" : "PRAGMA locking_mode = EXCLUSIVE; ";
  if (auto set = database.execute(fmt::format("{}PRAGMA temp_store = MEMORY; PRAGMA cell_size_check = ON", locking));
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

Result<void> Database::checkpoint_log(int mode) {
  const int code = sqlite3_wal_checkpoint_v2(connection_.get(), "main", mode, nullptr, nullptr);
  if (code == SQLITE_OK) return {};
  return failure(last_fault(connection_.get()));
}

Result<void> Database::checkpoint_log() { return checkpoint_log(SQLITE_CHECKPOINT_PASSIVE); }

Result<void> Database::empty_log() {
  auto done = checkpoint_log(SQLITE_CHECKPOINT_TRUNCATE);
  if (done && log_pages_) *log_pages_ = 0;
  return done;
}

void Database::forget_pages() { sqlite3_db_release_memory(connection_.get()); }

void Database::keep_log_on_close() {
  sqlite3_db_config(connection_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
}

Result<void> Database::execute(const std::string& sql) {
  if (sqlite3_exec(connection_.get(), sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
  return failure(last_fault(connection_.get()));
}

Result<Statement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v3(connection_.get(), sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (code != SQLITE_OK) return failure(last_fault(connection_.get()));
  return Statement(statement);
}

Result<std::optional<Statement>> Database::first_row(std::string_view sql) {
  auto query = prepare(sql);
  if (!query) return failure(query.error());
  const auto row = query->step();
  if (!row) return failure(row.error());
  return *row ? std::optional(std::move(*query)) : std::nullopt;
}

Result<std::string> Database::query_text(std::string_view sql) {
  auto row = first_row(sql);
  if (!row) return failure(row.error());
  if (!*row) return std::string();
  std::string first((*row)->text(0));
  // A statement that also writes completes the write, or fails, only in its last step.
  if (const auto more = (*row)->step(); !more) return failure(more.error());
  return first;
}

Result<std::int64_t> Database::query_integer(std::string_view sql, std::int64_t fallback) {
  return first_row(sql).map(
      [&](const std::optional<Statement>& row) { return row && !row->null(0) ? row->integer(0) : fallback; });
}

namespace {

struct Setting {
  const char* pragma;
  const char* value;
  const char* read_back;
};

/// FULL syncs every commit. Automatic checkpoints are off, because SQLite does not report their failure.
constexpr std::array kDurable{
    Setting{"journal_mode", "WAL", "wal"},
    Setting{"synchronous", "FULL", "2"},
    Setting{"wal_autocheckpoint", "0", "0"},
};
constexpr Setting kExclusive{"locking_mode", "EXCLUSIVE", "exclusive"};
/// Keeps the journal in memory on leaving WAL mode. SQLite then rewrites the first page, in which only bytes 18 to 99
/// change. A disk that writes whole sectors has either the old page or the new one, and both are readable. WAL mode is
/// entered while the file is still empty.
constexpr Setting kNoJournal{"journal_mode", "MEMORY", "memory"};

Result<void> apply(Database& database, const Setting& setting, const std::string& path) {
  if (const auto set = database.query_text(fmt::format("PRAGMA {} = {}", setting.pragma, setting.value)); !set)
    return failure(set.error());
  const auto now = database.query_text(fmt::format("PRAGMA {}", setting.pragma));
  if (!now) return failure(now.error());
  if (*now == setting.read_back) return {};
  return failure(FaultKind::storage, path,
                 fmt::format("SQLite keeps {} at \"{}\", expected \"{}\"", setting.pragma, *now, setting.read_back));
}

}  // namespace

Result<void> make_new_file(const std::string& path) {
  // SQLite creates the log with the same mode.
  constexpr mode_t kGroupReadable = 0640;
  const int file = ::open(path.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_WRONLY | O_CLOEXEC, kGroupReadable);
  if (file < 0 && errno == EEXIST)
    return failure(FaultKind::storage, path, "exists already, and a record is never overwritten");
  if (file < 0) return failure(FaultKind::storage, path, std::strerror(errno));
  ::close(file);
  return {};
}

Result<void> lock_exclusively(Database& database, const std::string& path) { return apply(database, kExclusive, path); }

Result<void> keep_journal_in_memory(Database& database, const std::string& path) {
  return apply(database, kNoJournal, path);
}

Result<void> make_durable(Database& database, const std::string& path) {
  for (const Setting& setting : kDurable)
    if (auto applied = apply(database, setting, path); !applied) return applied;
  return {};
}

namespace {

constexpr std::string_view kLog = "-wal";
constexpr std::string_view kJournal = "-journal";
/// SQLite's lock bytes: PENDING, RESERVED, then 510 bytes SHARED.
constexpr sqlite3_int64 kFirstLockedByte = 0x40000000;
constexpr sqlite3_int64 kLockedBytes = 512;

/// The state of an open file. SQLite allocates its memory.
struct OpenFile {
  sqlite3_file base;
  int descriptor;
  /// A database without a log. It cannot change while the lock excludes writers.
  bool has_no_log;
};

OpenFile& as_open_file(sqlite3_file* file) { return *reinterpret_cast<OpenFile*>(file); }

int close_file(sqlite3_file* file) {
  ::close(as_open_file(file).descriptor);
  return SQLITE_OK;
}

int read_bytes(sqlite3_file* file, void* into, int size, sqlite3_int64 offset) {
  auto* bytes = static_cast<char*>(into);
  int taken = 0;
  while (taken < size) {
    const auto count =
        ::pread(as_open_file(file).descriptor, bytes + taken, static_cast<std::size_t>(size - taken), offset + taken);
    if (count < 0 && errno != EINTR) return SQLITE_IOERR_READ;
    if (count == 0) break;
    if (count > 0) taken += static_cast<int>(count);
  }
  if (taken == size) return SQLITE_OK;
  std::memset(bytes + taken, 0, static_cast<std::size_t>(size - taken));
  return SQLITE_IOERR_SHORT_READ;
}

int refuse_write(sqlite3_file* /*file*/, const void* /*from*/, int /*size*/, sqlite3_int64 /*offset*/) {
  return SQLITE_READONLY;
}

int refuse_truncate(sqlite3_file* /*file*/, sqlite3_int64 /*size*/) { return SQLITE_READONLY; }

int sync_nothing(sqlite3_file* /*file*/, int /*flags*/) { return SQLITE_OK; }

int file_size(sqlite3_file* file, sqlite3_int64* size) {
  struct stat facts {};
  if (::fstat(as_open_file(file).descriptor, &facts) != 0) return SQLITE_IOERR_FSTAT;
  *size = facts.st_size;
  return SQLITE_OK;
}

int lock_nothing(sqlite3_file* /*file*/, int /*level*/) { return SQLITE_OK; }

int check_reserved_lock(sqlite3_file* /*file*/, int* held) {
  *held = 0;
  return SQLITE_OK;
}

int file_control(sqlite3_file* /*file*/, int /*what*/, void* /*argument*/) { return SQLITE_NOTFOUND; }

int sector_size(sqlite3_file* /*file*/) { return 4096; }

int device_characteristics(sqlite3_file* file) { return as_open_file(file).has_no_log ? SQLITE_IOCAP_IMMUTABLE : 0; }

const sqlite3_io_methods kReading{1,
                                  close_file,
                                  read_bytes,
                                  refuse_write,
                                  refuse_truncate,
                                  sync_nothing,
                                  file_size,
                                  lock_nothing,
                                  lock_nothing,
                                  check_reserved_lock,
                                  file_control,
                                  sector_size,
                                  device_characteristics,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  nullptr};

/// Returns the range of bytes that SQLite locks.
struct flock locked_range(short type) {
  struct flock range {};
  range.l_type = type;
  range.l_whence = SEEK_SET;
  range.l_start = kFirstLockedByte;
  range.l_len = kLockedBytes;
  return range;
}

/// Locks the file against writers. Returns false if a writer has locked it. Returns true on a file system without
/// locks.
bool lock_out_writers(int file) {
  auto range = locked_range(F_RDLCK);
  return ::fcntl(file, F_OFD_SETLK, &range) == 0 || (errno != EAGAIN && errno != EACCES);
}

/// Returns whether another program holds a lock that conflicts with `lock` on the open file.
bool has_conflicting_lock(short lock, int file) {
  auto range = locked_range(lock);
  return ::fcntl(file, F_OFD_GETLK, &range) == 0 && range.l_type != F_UNLCK;
}

bool has_content(const std::string& path) {
  struct stat facts {};
  return ::stat(path.c_str(), &facts) == 0 && (!S_ISREG(facts.st_mode) || facts.st_size > 0);
}

int open_to_read(sqlite3_vfs* /*vfs*/, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  file->pMethods = nullptr;
  const bool is_database = (flags & SQLITE_OPEN_MAIN_DB) != 0;
  if (name == nullptr || (!is_database && (flags & SQLITE_OPEN_WAL) == 0)) return SQLITE_CANTOPEN;
  auto opened = open_regular_file(name);
  if (!opened) return SQLITE_CANTOPEN;
  if (is_database && !lock_out_writers(opened->descriptor.number())) return SQLITE_BUSY;
  as_open_file(file).has_no_log = is_database && !has_content(std::string(name).append(kLog));
  as_open_file(file).descriptor = std::move(opened->descriptor).release();
  file->pMethods = &kReading;
  if (out_flags != nullptr) *out_flags = SQLITE_OPEN_READONLY;
  return SQLITE_OK;
}

/// Removes nothing and reports success, because reading does not depend on the removal.
int remove_nothing(sqlite3_vfs* /*vfs*/, const char* /*name*/, int /*sync_folder*/) { return SQLITE_OK; }

int check_access(sqlite3_vfs* /*vfs*/, const char* name, int flags, int* out) {
  const bool shown = flags != SQLITE_ACCESS_READWRITE && !std::string_view(name).ends_with(kJournal);
  *out = shown && has_content(name) ? 1 : 0;
  return SQLITE_OK;
}

sqlite3_vfs& default_vfs() { return *sqlite3_vfs_find("unix"); }

int full_path(sqlite3_vfs* /*vfs*/, const char* name, int size, char* out) {
  return default_vfs().xFullPathname(&default_vfs(), name, size, out);
}

int randomness(sqlite3_vfs* /*vfs*/, int size, char* out) {
  return default_vfs().xRandomness(&default_vfs(), size, out);
}

int vfs_pause(sqlite3_vfs* /*vfs*/, int microseconds) { return default_vfs().xSleep(&default_vfs(), microseconds); }

int current_time(sqlite3_vfs* /*vfs*/, double* day) { return default_vfs().xCurrentTime(&default_vfs(), day); }

int last_error(sqlite3_vfs* /*vfs*/, int /*size*/, char* /*out*/) { return errno; }

}  // namespace

const char* reader_vfs() {
  static sqlite3_vfs vfs = [] {
    sqlite3_vfs reader{};
    reader.iVersion = 1;
    reader.szOsFile = sizeof(OpenFile);
    reader.mxPathname = default_vfs().mxPathname;
    reader.zName = "gyrotherm-reader";
    reader.xOpen = open_to_read;
    reader.xDelete = remove_nothing;
    reader.xAccess = check_access;
    reader.xFullPathname = full_path;
    reader.xRandomness = randomness;
    reader.xSleep = vfs_pause;
    reader.xCurrentTime = current_time;
    reader.xGetLastError = last_error;
    return reader;
  }();
  static const int registered = sqlite3_vfs_register(&vfs, 0);
  return registered == SQLITE_OK ? vfs.zName : nullptr;
}

bool is_being_read(const std::string& path) {
  if (is_written_by_this_process(path)) return false;
  const auto file = open_regular_file(path);
  return file && has_conflicting_lock(F_WRLCK, file->descriptor.number()) &&
         !has_conflicting_lock(F_RDLCK, file->descriptor.number());
}

bool is_being_written(const std::string& path) {
  if (is_written_by_this_process(path)) return true;
  const auto file = open_regular_file(path);
  return file && has_conflicting_lock(F_RDLCK, file->descriptor.number());
}

namespace {

using FileId = std::pair<dev_t, ino_t>;

struct WrittenFiles {
  std::mutex mutex;
  std::multiset<FileId> files;
};

WrittenFiles& written_files() {
  static WrittenFiles all;
  return all;
}

std::optional<FileId> file_id(const std::string& path) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) return std::nullopt;
  return FileId{facts.st_dev, facts.st_ino};
}

}  // namespace

WrittenHere::WrittenHere(const std::string& path) : file_(file_id(path)) {
  const std::lock_guard lock(written_files().mutex);
  if (file_) written_files().files.insert(*file_);
}

WrittenHere::~WrittenHere() {
  if (!file_) return;
  const std::lock_guard lock(written_files().mutex);
  if (const auto found = written_files().files.find(*file_); found != written_files().files.end())
    written_files().files.erase(found);
}

bool is_written_by_this_process(const std::string& path) {
  const auto file = file_id(path);
  const std::lock_guard lock(written_files().mutex);
  return file && written_files().files.contains(*file);
}

}  // namespace gyrotherm::record
