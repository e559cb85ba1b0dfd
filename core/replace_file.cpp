#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "core/text_file.hpp"

namespace gyrotherm {
namespace {

constexpr mode_t kForAll = 0644;
constexpr mode_t kForTheGroup = 0640;
constexpr int kMostNames = 100;                 ///< drawn one after the other while somebody has each of them
constexpr std::size_t kLongestBeginning = 200;  ///< of a new name, of which 255 bytes may be used

/// What a path says in two: the folder, open, and the name in it.
struct Place {
  Descriptor folder;
  std::string name;
};

/// Fails with errno's words.
Result<Place> place_of(const std::string& path) {
  const std::filesystem::path whole(path);
  const auto parent = whole.parent_path().string();
  Place place{.folder = Descriptor(::open(parent.empty() ? "." : parent.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)),
              .name = whole.filename().string()};
  if (!place.folder.is_open())
    return failure(FaultKind::storage, path, std::string("cannot be written: ") + std::strerror(errno));
  if (place.name.empty() || place.name == "." || place.name == "..")
    return failure(FaultKind::storage, path, "cannot be written: is a folder");
  return place;
}

/// A name beside the other one that nobody can know beforehand.
std::string new_name_beside(const std::string& name) {
  std::uint64_t drawn{};
  while (::getrandom(&drawn, sizeof drawn, 0) != sizeof drawn) {
  }
  return fmt::format("{}.{:016x}.part", name.substr(0, kLongestBeginning), drawn);
}

/// A file that was not there before, open for writing under a new name; closed with errno set if there is none.
Descriptor make_new(const Place& place, std::string& name, mode_t mode) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  for (int i = 0; i < kMostNames; ++i) {
    name = new_name_beside(place.name);
    Descriptor file(::openat(place.folder.number(), name.c_str(), kFlags, mode));
    if (file.is_open() || errno != EEXIST) return file;
  }
  return {};
}

/// Writes all; false with errno set.
bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const auto written = ::write(file, text.data(), text.size());
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

void sync_folder(const Place& place) {
  const Descriptor folder(::openat(place.folder.number(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.is_open()) ::fsync(folder.number());
}

struct Manner {
  mode_t mode{};
  bool whatever_the_umask{};
  Syncing syncing{};
};

/// False with errno set; then nothing is left of it.
bool replace_in(const Place& place, std::string_view text, const Manner& manner) {
  std::string name;
  const auto file = make_new(place, name, manner.mode);
  if (!file.is_open()) return false;
  const bool done = (!manner.whatever_the_umask || ::fchmod(file.number(), manner.mode) == 0) &&
                    write_all(file.number(), text) &&
                    (manner.syncing == Syncing::not_awaited || ::fsync(file.number()) == 0) &&
                    ::renameat(place.folder.number(), name.c_str(), place.folder.number(), place.name.c_str()) == 0;
  if (done) return true;
  const int error = errno;
  ::unlinkat(place.folder.number(), name.c_str(), 0);
  errno = error;
  return false;
}

Result<void> replace(const std::string& path, const std::string& target, std::string_view text, const Manner& manner) {
  const auto place = place_of(target);
  if (!place) return failure(place.error().kind, path, place.error().what);
  if (!replace_in(*place, text, manner))
    return failure(FaultKind::storage, path, std::string("cannot be written: ") + std::strerror(errno));
  if (manner.syncing == Syncing::awaited) sync_folder(*place);
  return {};
}

}  // namespace

Result<void> replace_text_file(const std::string& path, std::string_view text) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    return failure(FaultKind::storage, path, "is there and is no regular file; it is not replaced");
  const auto target = std::filesystem::weakly_canonical(path, error).string();
  return replace(path, target.empty() ? path : target, text,
                 {.mode = kForAll, .whatever_the_umask = false, .syncing = Syncing::awaited});
}

Result<void> replace_own_file(const std::string& path, std::string_view text, Syncing syncing) {
  return replace(path, path, text, {.mode = kForTheGroup, .whatever_the_umask = true, .syncing = syncing});
}

}  // namespace gyrotherm
