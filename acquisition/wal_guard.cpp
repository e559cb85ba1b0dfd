#include "acquisition/wal_guard.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <utility>

namespace gyrotherm {
namespace {

bool same_file(const std::string& a, const std::string& b) {
  struct stat of_a {};
  struct stat of_b {};
  return ::stat(a.c_str(), &of_a) == 0 && ::stat(b.c_str(), &of_b) == 0 && of_a.st_dev == of_b.st_dev &&
         of_a.st_ino == of_b.st_ino;
}

}  // namespace

Result<WalGuard> WalGuard::find(const std::string& path) {
  const std::string log = path + "-wal";
  std::error_code error;
  for (const auto& held : std::filesystem::directory_iterator("/proc/self/fd", error))
    if (same_file(log, held.path())) return WalGuard(log, held.path());
  return failure(FaultKind::storage, log, "no descriptor of this process holds the log");
}

Result<void> WalGuard::check() const {
  if (same_file(log_, held_)) return {};
  return failure(FaultKind::storage, log_,
                 "the log being written is not the one on disk; another program has opened the record");
}

}  // namespace gyrotherm
