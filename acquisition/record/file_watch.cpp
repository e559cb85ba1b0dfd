#include "acquisition/record/file_watch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <utility>
#include <vector>

#include "acquisition/record/log_check.hpp"
#include "core/file.hpp"

namespace gyrotherm {
namespace {

/// The descriptor of this process that holds the file of that name; kNoDescriptor if none does.
int descriptor_of(int folder, const std::string& name) {
  struct stat wanted {};
  if (::fstatat(folder, name.c_str(), &wanted, AT_SYMLINK_NOFOLLOW) != 0) return kNoDescriptor;
  for (const auto& held : entries_of("/proc/self/fd")) {
    const auto text = held.filename().string();
    int number = kNoDescriptor;
    struct stat found {};
    std::from_chars(text.data(), text.data() + text.size(), number);
    if (::fstat(number, &found) == 0 && found.st_dev == wanted.st_dev && found.st_ino == wanted.st_ino) return number;
  }
  return kNoDescriptor;
}

std::int64_t big_endian(const unsigned char* bytes) {
  return std::int64_t{bytes[0]} << 24 | bytes[1] << 16 | bytes[2] << 8 | bytes[3];
}

/// Where the pages lie in the database that the frames of a log are of; some may be of an older log (SQLite, "WAL-mode
/// File Format").
std::vector<std::int64_t> pages_in(int log, std::int64_t length) {
  constexpr std::int64_t kHeader = 32, kPageSizeAt = 8, kFrameHeader = 24;
  std::array<unsigned char, 4> number{};
  const auto read = [&](std::int64_t at) { return ::pread(log, number.data(), number.size(), at) == 4; };
  std::vector<std::int64_t> places;
  if (!read(kPageSizeAt)) return places;
  const auto page = big_endian(number.data());
  for (auto at = kHeader; page > 0 && at + kFrameHeader + page <= length; at += kFrameHeader + page)
    if (read(at)) places.push_back((big_endian(number.data()) - 1) * page);
  return places;
}

std::int64_t nanoseconds(const timespec& time) {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  return time.tv_sec * kNanoseconds + time.tv_nsec;
}

Interference interference(Interference::Kind kind, bool of_log, const std::string& name, const char* what) {
  return {.kind = kind,
          .of_log = of_log,
          .words = fmt::format("{} was {} by another program while it was being written", name, what)};
}

}  // namespace

/// The log's own sums show what its times do not, and may not change because somebody gave it another mode.
std::optional<FileWatch::Seen> FileWatch::see(const File& file) {
  struct stat found {};
  if (::fstat(file.held, &found) != 0) return {};
  return Seen{.device = found.st_dev,
              .inode = found.st_ino,
              .length = found.st_size,
              .written_ns = nanoseconds(found.st_mtim),
              .changed_ns = file.is_log ? 0 : nanoseconds(found.st_ctim)};
}

Result<FileWatch> FileWatch::begin(const std::string& path) {
  std::error_code error;
  const auto split = std::filesystem::absolute(path, error);
  const auto parent = split.parent_path().string();
  auto folder = std::make_shared<Descriptor>(::open(parent.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  const auto name = split.filename().string();
  std::array<File, 2> files{
      {{.name = name, .held = kNoDescriptor, .seen = {}, .is_log = false, .content = {}},
       {.name = name + "-wal", .held = kNoDescriptor, .seen = {}, .is_log = true, .content = {}}}};
  for (auto& file : files) {
    file.held = descriptor_of(folder->number(), file.name);
    if (file.held == kNoDescriptor)
      return failure(FaultKind::storage, parent + "/" + file.name, "no descriptor of this process holds it");
  }
  FileWatch watch(parent, std::move(folder), std::move(files));
  watch.remember();
  return watch;
}

void FileWatch::remember_log() {
  if (const auto now = see(files_[1])) files_[1].seen = *now;
}

void FileWatch::remember_fold() {
  remember_log();
  auto& database = files_[0];
  const auto now = see(database);
  if (!now || *now == database.seen) return;
  database.content.renew(database.held, now->length, pages_in(files_[1].held, files_[1].seen.length));
  database.seen = *now;
}

void FileWatch::remember() {
  remember_log();
  auto& database = files_[0];
  const auto now = see(database);
  if (!now) return;
  database.content = BlockSums::of(database.held, now->length);
  database.seen = *now;
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
  if (file.is_log || now.length != file.seen.length || BlockSums::of(file.held, file.seen.length) != file.content)
    return false;
  file.seen = now;
  return true;
}

std::optional<Interference> FileWatch::judge_content(File& file) {
  const auto now = see(file);
  if ((now && *now == file.seen) || (now && was_merely_touched(file, *now))) return {};
  return interference(Interference::Kind::spoiled, file.is_log, file.name,
                      now && now->length < file.seen.length ? "cut short" : "written to");
}

/// What happened to the database is the graver.
std::optional<Interference> FileWatch::look() {
  if (auto found = judge_names()) return found;
  for (auto& file : files_)
    if (auto found = judge_content(file)) return found;
  return {};
}

std::optional<Interference> FileWatch::judge_folder() const {
  struct stat named {
  }, held{};
  if (::stat(place_.c_str(), &named) != 0) return {};  // nowhere to go on but in the files that are held
  if (::fstat(folder_->number(), &held) != 0 || named.st_dev != held.st_dev || named.st_ino != held.st_ino)
    return interference(Interference::Kind::taken_away, false,
                        "the folder " + std::filesystem::path(place_).filename().string(), "replaced");
  return {};
}

std::optional<Interference> FileWatch::judge_names() const {
  if (auto found = judge_folder()) return found;
  for (const auto& file : files_)
    if (auto found = judge_name(file)) return found;
  return {};
}

std::optional<Interference> FileWatch::look_at_log(std::int64_t frames) const {
  const auto& log = files_[1];
  if (log_is_whole(log.held, frames)) return {};
  return interference(Interference::Kind::spoiled, true, log.name, "written to");
}

std::optional<Interference> FileWatch::look_after_writing(std::int64_t frames) {
  constexpr Duration kPause = std::chrono::milliseconds(500);
  if (auto found = judge_names()) return found;
  const auto now = clock_.now().since_start;
  if (log_seen_ && now - *log_seen_ < kPause) return {};
  log_seen_ = now;
  return look_at_log(frames);
}

std::optional<Interference> FileWatch::look_closely(std::int64_t frames) const {
  const auto& database = files_[0];
  if (auto found = judge_names()) return found;
  if (::access(place_.c_str(), F_OK) != 0)
    return interference(Interference::Kind::taken_away, false, "the folder " + place_, "removed or moved");
  if (BlockSums::of(database.held, database.seen.length) != database.content)
    return interference(Interference::Kind::spoiled, false, database.name, "written to");
  return look_at_log(frames);
}

}  // namespace gyrotherm
