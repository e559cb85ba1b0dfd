// SPDX-License-Identifier: Apache-2.0
#include "tests/support/failing_vfs.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <new>
#include <random>
#include <utility>

namespace gyrotherm::tests {
namespace {

/// SQLite's handle of an open file. In memory, it is followed by the handle of the underlying file system.
struct OpenFile {
  sqlite3_file base;
  FailingVfs* vfs;
  std::string* path;
  sqlite3_file* below() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

OpenFile& of(sqlite3_file* file) { return *reinterpret_cast<OpenFile*>(file); }

int close(sqlite3_file* file) {
  const int code = of(file).below()->pMethods->xClose(of(file).below());
  delete of(file).path;
  return code;
}

int read(sqlite3_file* file, void* into, int size, sqlite3_int64 offset) {
  if (const int code = of(file).vfs->count('r')) return code;
  return of(file).below()->pMethods->xRead(of(file).below(), into, size, offset);
}

int write(sqlite3_file* file, const void* from, int size, sqlite3_int64 offset) {
  if (const int code = of(file).vfs->count('w')) return code;
  const std::string other(static_cast<std::size_t>(size), '\0');
  if (of(file).vfs->forgets()) from = other.data();
  of(file).vfs->wrote(*of(file).path, offset, {static_cast<const char*>(from), static_cast<std::size_t>(size)});
  return of(file).below()->pMethods->xWrite(of(file).below(), from, size, offset);
}

int truncate(sqlite3_file* file, sqlite3_int64 size) {
  if (const int code = of(file).vfs->count('t')) return code;
  of(file).vfs->truncated(*of(file).path, size);
  return of(file).below()->pMethods->xTruncate(of(file).below(), size);
}

int sync(sqlite3_file* file, int /*flags*/) {
  if (const int code = of(file).vfs->count('s')) {
    of(file).vfs->failed_to_sync(*of(file).path);
    return code;
  }
  of(file).vfs->synced(*of(file).path);
  return SQLITE_OK;
}

int file_size(sqlite3_file* file, sqlite3_int64* size) {
  return of(file).below()->pMethods->xFileSize(of(file).below(), size);
}

int lock(sqlite3_file* file, int level) {
  if (const int code = of(file).vfs->count('l')) return code;
  return of(file).below()->pMethods->xLock(of(file).below(), level);
}

int unlock(sqlite3_file* file, int level) { return of(file).below()->pMethods->xUnlock(of(file).below(), level); }

int check_reserved(sqlite3_file* file, int* held) {
  return of(file).below()->pMethods->xCheckReservedLock(of(file).below(), held);
}

int control(sqlite3_file* file, int what, void* argument) {
  return of(file).below()->pMethods->xFileControl(of(file).below(), what, argument);
}

int sector_size(sqlite3_file* file) { return of(file).below()->pMethods->xSectorSize(of(file).below()); }

int characteristics(sqlite3_file* file) { return of(file).below()->pMethods->xDeviceCharacteristics(of(file).below()); }

// Shared memory is used only by readers of a log that a writer left behind.
int map_shared(sqlite3_file* file, int region, int size, int extend, void volatile** memory) {
  return of(file).below()->pMethods->xShmMap(of(file).below(), region, size, extend, memory);
}

int lock_shared(sqlite3_file* file, int offset, int count, int flags) {
  return of(file).below()->pMethods->xShmLock(of(file).below(), offset, count, flags);
}

void order_shared(sqlite3_file* file) { of(file).below()->pMethods->xShmBarrier(of(file).below()); }

int unmap_shared(sqlite3_file* file, int remove_it) {
  return of(file).below()->pMethods->xShmUnmap(of(file).below(), remove_it);
}

const sqlite3_io_methods kMethods{2,
                                  close,
                                  read,
                                  write,
                                  truncate,
                                  sync,
                                  file_size,
                                  lock,
                                  unlock,
                                  check_reserved,
                                  control,
                                  sector_size,
                                  characteristics,
                                  map_shared,
                                  lock_shared,
                                  order_shared,
                                  unmap_shared,
                                  nullptr,
                                  nullptr};

FailingVfs& vfs_of(sqlite3_vfs* vfs) { return *static_cast<FailingVfs*>(vfs->pAppData); }

int open(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* out_flags) {
  file->pMethods = nullptr;
  if (const int code = vfs_of(vfs).count('o')) return code;
  OpenFile& opened = of(file);
  const int code = vfs_of(vfs).below()->xOpen(vfs_of(vfs).below(), name, opened.below(), flags, out_flags);
  if (code != SQLITE_OK) return code;
  opened.vfs = &vfs_of(vfs);
  opened.path = new std::string(name != nullptr ? name : "");
  file->pMethods = &kMethods;
  return SQLITE_OK;
}

int remove(sqlite3_vfs* vfs, const char* name, int sync_folder) {
  if (const int code = vfs_of(vfs).count('d')) return code;
  vfs_of(vfs).deleted(name);
  return vfs_of(vfs).below()->xDelete(vfs_of(vfs).below(), name, sync_folder);
}

int access(sqlite3_vfs* vfs, const char* name, int flags, int* out) {
  return vfs_of(vfs).below()->xAccess(vfs_of(vfs).below(), name, flags, out);
}

int full_path(sqlite3_vfs* vfs, const char* name, int size, char* out) {
  return vfs_of(vfs).below()->xFullPathname(vfs_of(vfs).below(), name, size, out);
}

sqlite3_vfs& registered() {
  static sqlite3_vfs vfs{};
  return vfs;
}

void put(std::string& image, std::size_t offset, std::string_view bytes) {
  if (image.size() < offset + bytes.size()) image.resize(offset + bytes.size(), '\0');
  std::memcpy(image.data() + offset, bytes.data(), bytes.size());
}

int code_of(char operation) {
  switch (operation) {
    case 'o': return SQLITE_CANTOPEN;
    case 'r': return SQLITE_IOERR_READ;
    case 'w': return SQLITE_IOERR_WRITE;
    case 't': return SQLITE_IOERR_TRUNCATE;
    case 's': return SQLITE_IOERR_FSYNC;
    case 'l': return SQLITE_IOERR_LOCK;
    default: return SQLITE_IOERR_DELETE;
  }
}

}  // namespace

FailingVfs::FailingVfs() : below_(sqlite3_vfs_find("unix")) {
  sqlite3_vfs& vfs = registered();
  vfs = *below_;
  vfs.szOsFile = static_cast<int>(sizeof(OpenFile)) + below_->szOsFile;
  vfs.zName = "failing";
  vfs.pAppData = this;
  vfs.xOpen = open;
  vfs.xDelete = remove;
  vfs.xAccess = access;
  vfs.xFullPathname = full_path;
  sqlite3_vfs_register(&vfs, 1);
}

FailingVfs::~FailingVfs() {
  sqlite3_vfs_unregister(&registered());
  sqlite3_vfs_register(below_, 1);
}

void FailingVfs::fail(std::int64_t operation, bool sticky, Kind kind) {
  fail_at_ = operation;
  sticky_ = sticky;
  kind_ = kind;
  operations_ = 0;
  failures_ = 0;
}

bool FailingVfs::forgets() {
  if (kind_ != Kind::forgetful || ++operations_ < fail_at_ || fail_at_ == 0) return false;
  ++failures_;
  return true;
}

int FailingVfs::count(char operation) {
  if (kind_ == Kind::forgetful) return SQLITE_OK;
  if (kind_ == Kind::sync_error && operation != 's') return SQLITE_OK;
  if (kind_ == Kind::full && operation != 'w') return SQLITE_OK;
  ++operations_;
  if (fail_at_ == 0 || (sticky_ ? operations_ < fail_at_ : operations_ != fail_at_)) return SQLITE_OK;
  ++failures_;
  if (kind_ == Kind::full) return SQLITE_FULL;
  return code_of(operation);
}

void FailingVfs::wrote(const std::string& path, std::int64_t offset, std::string bytes) {
  disk_[path].pending.push_back({.offset = offset, .bytes = std::move(bytes), .truncation = false});
}

void FailingVfs::truncated(const std::string& path, std::int64_t size) {
  disk_[path].pending.push_back({.offset = size, .bytes = {}, .truncation = true});
}

void FailingVfs::synced(const std::string& path) {
  File& file = disk_[path];
  for (const Change& change : file.pending) {
    const auto offset = static_cast<std::size_t>(change.offset);
    if (change.truncation) {
      file.durable.resize(offset);
    } else {
      put(file.durable, offset, change.bytes);
    }
  }
  file.pending.clear();
}

void FailingVfs::lose_unsynced_data(unsigned seed) {
  constexpr std::size_t kSector = 512;
  std::mt19937 random(seed);
  for (auto& [path, file] : disk_) {
    std::string image = file.durable;
    for (const Change& change : file.pending) {
      if (change.truncation) {
        if (random() % 2 == 0) image.resize(static_cast<std::size_t>(change.offset));
        continue;
      }
      const auto offset = static_cast<std::size_t>(change.offset);
      const bool whole = random() % 2 == 0;  // otherwise sector by sector
      for (std::size_t at = 0; at < change.bytes.size(); at += kSector) {
        if (!whole && random() % 2 == 0) continue;
        put(image, offset + at, std::string_view(change.bytes).substr(at, kSector));
      }
    }
    std::ofstream(path, std::ios::binary | std::ios::trunc) << image;
  }
}

}  // namespace gyrotherm::tests
