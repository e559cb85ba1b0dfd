#include "acquisition/file_watch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

namespace gyrotherm {
namespace {

/// The descriptor of this process that holds the file of that name; kNoDescriptor if none does.
int descriptor_of(int folder, const std::string& name) {
  struct stat wanted {};
  if (::fstatat(folder, name.c_str(), &wanted, AT_SYMLINK_NOFOLLOW) != 0) return kNoDescriptor;
  std::error_code error;
  for (const auto& held : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const auto text = held.path().filename().string();
    int number = kNoDescriptor;
    struct stat found {};
    std::from_chars(text.data(), text.data() + text.size(), number);
    if (::fstat(number, &found) == 0 && found.st_dev == wanted.st_dev && found.st_ino == wanted.st_ino) return number;
  }
  return kNoDescriptor;
}

/// A sum of the first `length` bytes that anything but intent changes: FNV-1a over words of eight bytes.
std::uint64_t sum_of(int descriptor, std::int64_t length) {
  constexpr std::uint64_t kStart = 0xCBF29CE484222325U, kPrime = 0x100000001B3U;
  constexpr std::size_t kWords = 8192;
  std::vector<std::uint64_t> piece(kWords);
  std::uint64_t sum = kStart;
  for (std::int64_t at = 0; at < length;) {
    const auto most = std::min<std::int64_t>(length - at, kWords * sizeof(std::uint64_t));
    const auto size = ::pread(descriptor, piece.data(), static_cast<std::size_t>(most), at);
    if (size <= 0) return 0;
    const auto whole = (static_cast<std::size_t>(size) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
    std::memset(reinterpret_cast<char*>(piece.data()) + size, 0,
                whole * sizeof(std::uint64_t) - static_cast<std::size_t>(size));
    for (std::size_t i = 0; i < whole; ++i) {
      sum = (sum ^ piece[i]) * kPrime;
      sum ^= sum >> 32;  // what is in the upper half counts below, too
    }
    at += size;
  }
  return sum;
}

Interference interference(Interference::Kind kind, bool of_log, const std::string& name, const char* what) {
  return {.kind = kind,
          .of_log = of_log,
          .words = fmt::format("{} was {} by another program while it was being written", name, what)};
}

}  // namespace

std::optional<FileWatch::Seen> FileWatch::see(int descriptor) {
  struct stat found {};
  if (::fstat(descriptor, &found) != 0) return {};
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  return Seen{.device = found.st_dev,
              .inode = found.st_ino,
              .length = found.st_size,
              .written_ns = found.st_mtim.tv_sec * kNanoseconds + found.st_mtim.tv_nsec};
}

Result<FileWatch> FileWatch::begin(const std::string& path) {
  const auto split = std::filesystem::path(path);
  const auto parent = split.parent_path().empty() ? std::string(".") : split.parent_path().string();
  auto folder = std::make_shared<Descriptor>(::open(parent.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  const auto name = split.filename().string();
  std::array<File, 2> files{{{.name = name, .held = kNoDescriptor, .seen = {}, .is_log = false},
                             {.name = name + "-wal", .held = kNoDescriptor, .seen = {}, .is_log = true}}};
  for (auto& file : files) {
    file.held = descriptor_of(folder->number(), file.name);
    if (file.held == kNoDescriptor)
      return failure(FaultKind::storage, parent + "/" + file.name, "no descriptor of this process holds it");
  }
  FileWatch watch(std::move(folder), std::move(files));
  watch.remember();
  return watch;
}

void FileWatch::remember(File& file) {
  const auto now = see(file.held);
  if (!now || *now == file.seen) return;
  if (!file.is_log) file.content = sum_of(file.held, now->length);
  file.seen = *now;
}

void FileWatch::remember_log() { remember(files_[1]); }

void FileWatch::remember() {
  for (auto& file : files_) remember(file);
}

std::optional<Interference> FileWatch::judge_name(const File& file) const {
  struct stat named {};
  if (::fstatat(folder_->number(), file.name.c_str(), &named, AT_SYMLINK_NOFOLLOW) != 0)
    return interference(Interference::Kind::taken_away, file.is_log, file.name, "removed or moved");
  if (named.st_dev != file.seen.device || named.st_ino != file.seen.inode)
    return interference(Interference::Kind::taken_away, file.is_log, file.name, "replaced");
  return {};
}

/// Of a log a crash would keep nothing behind what somebody wrote.
bool FileWatch::was_merely_touched(File& file, const Seen& now) {
  if (file.is_log || now.length != file.seen.length || sum_of(file.held, file.seen.length) != file.content)
    return false;
  file.seen.written_ns = now.written_ns;
  return true;
}

std::optional<Interference> FileWatch::judge_content(File& file) {
  const auto now = see(file.held);
  if ((now && *now == file.seen) || (now && was_merely_touched(file, *now))) return {};
  return interference(Interference::Kind::spoiled, file.is_log, file.name,
                      now && now->length < file.seen.length ? "cut short" : "written to");
}

/// What happened to the database is the graver.
std::optional<Interference> FileWatch::look() {
  if (auto found = look_at_names()) return found;
  for (auto& file : files_)
    if (auto found = judge_content(file)) return found;
  return {};
}

std::optional<Interference> FileWatch::look_at_names() const {
  for (const auto& file : files_)
    if (auto found = judge_name(file)) return found;
  return {};
}

}  // namespace gyrotherm
