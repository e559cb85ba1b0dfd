#include "acquisition/record/reader_vfs.hpp"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "core/file.hpp"

namespace gyrotherm {
namespace {

constexpr std::string_view kLog = "-wal";
constexpr std::string_view kJournal = "-journal";
constexpr sqlite3_int64 kFirstLockedByte = 0x40000000;  ///< PENDING, RESERVED, then 510 bytes SHARED
constexpr sqlite3_int64 kLockedBytes = 512;

/// What SQLite holds of an open file, in memory of its own.
struct ReadFile {
  sqlite3_file base;
  int descriptor;
  bool lies_alone;  ///< a database without a log: it cannot change, for a writer is kept out
};

ReadFile& of(sqlite3_file* file) { return *reinterpret_cast<ReadFile*>(file); }

int close_file(sqlite3_file* file) {
  ::close(of(file).descriptor);
  return SQLITE_OK;
}

int read_bytes(sqlite3_file* file, void* into, int size, sqlite3_int64 offset) {
  auto* bytes = static_cast<char*>(into);
  int taken = 0;
  while (taken < size) {
    const auto count =
        ::pread(of(file).descriptor, bytes + taken, static_cast<std::size_t>(size - taken), offset + taken);
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

int size_of(sqlite3_file* file, sqlite3_int64* size) {
  struct stat facts {};
  if (::fstat(of(file).descriptor, &facts) != 0) return SQLITE_IOERR_FSTAT;
  *size = facts.st_size;
  return SQLITE_OK;
}

int lock_nothing(sqlite3_file* /*file*/, int /*level*/) { return SQLITE_OK; }

int none_reserved(sqlite3_file* /*file*/, int* held) {
  *held = 0;
  return SQLITE_OK;
}

int no_control(sqlite3_file* /*file*/, int /*what*/, void* /*argument*/) { return SQLITE_NOTFOUND; }

int usual_sector(sqlite3_file* /*file*/) { return 4096; }

int traits_of(sqlite3_file* file) { return of(file).lies_alone ? SQLITE_IOCAP_IMMUTABLE : 0; }

const sqlite3_io_methods kReading{1,         close_file,   read_bytes,   refuse_write,  refuse_truncate, sync_nothing,
                                  size_of,   lock_nothing, lock_nothing, none_reserved, no_control,      usual_sector,
                                  traits_of, nullptr,      nullptr,      nullptr,       nullptr,         nullptr,
                                  nullptr};

/// False if a writer has the file. Where the file system knows no locks, nobody can hold one.
bool keep_writers_out(int file) {
  struct flock range {};
  range.l_type = F_RDLCK;
  range.l_whence = SEEK_SET;
  range.l_start = kFirstLockedByte;
  range.l_len = kLockedBytes;
  return ::fcntl(file, F_OFD_SETLK, &range) == 0 || (errno != EAGAIN && errno != EACCES);
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
  if (is_database && !keep_writers_out(opened->descriptor.number())) return SQLITE_BUSY;
  of(file).lies_alone = is_database && !has_content(std::string(name).append(kLog));
  of(file).descriptor = std::move(opened->descriptor).release();
  file->pMethods = &kReading;
  if (out_flags != nullptr) *out_flags = SQLITE_OPEN_READONLY;
  return SQLITE_OK;
}

/// Whoever asks for it wants the file gone before it is read on; nothing here depends on that.
int remove_nothing(sqlite3_vfs* /*vfs*/, const char* /*name*/, int /*sync_folder*/) { return SQLITE_OK; }

int look(sqlite3_vfs* /*vfs*/, const char* name, int flags, int* out) {
  const bool shown = flags != SQLITE_ACCESS_READWRITE && !std::string_view(name).ends_with(kJournal);
  *out = shown && has_content(name) ? 1 : 0;
  return SQLITE_OK;
}

sqlite3_vfs& usual() { return *sqlite3_vfs_find("unix"); }

int full_path(sqlite3_vfs* /*vfs*/, const char* name, int size, char* out) {
  return usual().xFullPathname(&usual(), name, size, out);
}

int draw(sqlite3_vfs* /*vfs*/, int size, char* out) { return usual().xRandomness(&usual(), size, out); }

int pause(sqlite3_vfs* /*vfs*/, int microseconds) { return usual().xSleep(&usual(), microseconds); }

int tell_time(sqlite3_vfs* /*vfs*/, double* day) { return usual().xCurrentTime(&usual(), day); }

int last_error(sqlite3_vfs* /*vfs*/, int /*size*/, char* /*out*/) { return errno; }

}  // namespace

const char* reader_vfs() {
  static sqlite3_vfs vfs = [] {
    sqlite3_vfs reader{};
    reader.iVersion = 1;
    reader.szOsFile = sizeof(ReadFile);
    reader.mxPathname = usual().mxPathname;
    reader.zName = "gyrotherm-reader";
    reader.xOpen = open_to_read;
    reader.xDelete = remove_nothing;
    reader.xAccess = look;
    reader.xFullPathname = full_path;
    reader.xRandomness = draw;
    reader.xSleep = pause;
    reader.xCurrentTime = tell_time;
    reader.xGetLastError = last_error;
    return reader;
  }();
  static const int registered = sqlite3_vfs_register(&vfs, 0);
  return registered == SQLITE_OK ? vfs.zName : nullptr;
}

}  // namespace gyrotherm
