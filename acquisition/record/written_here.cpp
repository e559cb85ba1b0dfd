#include "acquisition/record/written_here.hpp"

#include <sys/stat.h>

#include <mutex>
#include <set>

namespace gyrotherm {
namespace {

using FileId = std::pair<dev_t, ino_t>;

struct Written {
  std::mutex mutex;
  std::multiset<FileId> files;
};

Written& written() {
  static Written all;
  return all;
}

std::optional<FileId> id_of(const std::string& path) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) return std::nullopt;
  return FileId{facts.st_dev, facts.st_ino};
}

}  // namespace

WrittenHere::WrittenHere(const std::string& path) : file_(id_of(path)) {
  const std::lock_guard lock(written().mutex);
  if (file_) written().files.insert(*file_);
}

WrittenHere::~WrittenHere() {
  if (!file_) return;
  const std::lock_guard lock(written().mutex);
  if (const auto found = written().files.find(*file_); found != written().files.end()) written().files.erase(found);
}

bool is_written_here(const std::string& path) {
  const auto file = id_of(path);
  const std::lock_guard lock(written().mutex);
  return file && written().files.contains(*file);
}

}  // namespace gyrotherm
