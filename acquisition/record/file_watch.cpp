// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/file_watch.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <utility>

namespace gyrotherm::record {

namespace {

using Bytes = std::span<const unsigned char>;

constexpr std::size_t kHeader = 32, kFrameHeader = 24;
constexpr std::size_t kSummedOfHeader = 24, kSummedOfFrameHeader = 8;
constexpr std::size_t kPageSizeAt = 8, kSaltsAt = 16, kFrameSaltsAt = 8, kSalts = 8;
constexpr std::uint32_t kMagic = 0x377F0682 | (std::endian::native == std::endian::big ? 1U : 0U);
constexpr std::uint32_t kLargestPage = 65536;

std::uint32_t read_big_endian(Bytes at) {
  return std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 | std::uint32_t{at[2]} << 8 | at[3];
}

std::uint32_t read_native(Bytes at) {
  std::uint32_t word = 0;
  std::memcpy(&word, at.data(), sizeof word);
  return word;
}

/// The checksum of a write-ahead log: a sum over 4-byte words, two at a time.
class LogSum {
 public:
  void add(Bytes bytes) {
    for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
      first_ += read_native(bytes.subspan(at)) + second_;
      second_ += read_native(bytes.subspan(at + 4)) + first_;
    }
  }
  [[nodiscard]] bool is(Bytes stored) const {
    return read_big_endian(stored) == first_ && read_big_endian(stored.subspan(4)) == second_;
  }

 private:
  std::uint32_t first_ = 0, second_ = 0;
};

bool read(int descriptor, std::vector<unsigned char>& into, std::size_t at) {
  return ::pread(descriptor, into.data(), into.size(), static_cast<off_t>(at)) == static_cast<ssize_t>(into.size());
}

}  // namespace

bool is_log_intact(int descriptor, std::int64_t frames) {
  std::vector<unsigned char> header(kHeader);
  if (frames == 0) return true;
  if (!read(descriptor, header, 0) || read_big_endian(header) != kMagic) return false;
  const Bytes head(header);
  const auto page = read_big_endian(head.subspan(kPageSizeAt));
  LogSum sum;
  sum.add(head.first(kSummedOfHeader));
  if (page == 0 || page > kLargestPage || !sum.is(head.subspan(kSummedOfHeader))) return false;
  std::vector<unsigned char> text(kFrameHeader + page);
  const Bytes frame(text);
  for (std::int64_t i = 0; i < frames; ++i) {
    if (!read(descriptor, text, kHeader + static_cast<std::size_t>(i) * text.size())) return false;
    if (!std::ranges::equal(frame.subspan(kFrameSaltsAt, kSalts), head.subspan(kSaltsAt, kSalts))) return false;
    sum.add(frame.first(kSummedOfFrameHeader));
    sum.add(frame.subspan(kFrameHeader));
    if (!sum.is(frame.subspan(kFrameSaltsAt + kSalts))) return false;
  }
  return true;
}

namespace {

constexpr std::int64_t kBlock = 65536;

std::int64_t count_blocks(std::int64_t length) { return (length + kBlock - 1) / kBlock; }

}  // namespace

/// Computes the FNV-1a hash of a block over 8-byte words.
void BlockSums::sum_block(int descriptor, std::int64_t block) {
  constexpr std::uint64_t kStart = 0xCBF29CE484222325U, kPrime = 0x100000001B3U;
  std::array<std::uint64_t, kBlock / sizeof(std::uint64_t)> words{};
  const auto size = std::min(length_ - block * kBlock, kBlock);
  auto& sum = sums_[static_cast<std::size_t>(block)];
  sum = 0;
  if (::pread(descriptor, words.data(), static_cast<std::size_t>(size), block * kBlock) != size) return;
  sum = kStart;
  for (const auto word : words) {
    sum = (sum ^ word) * kPrime;
    sum ^= sum >> 32;  // spreads the upper bits downwards
  }
}

void BlockSums::renew(int descriptor, std::int64_t length, std::span<const std::int64_t> offsets) {
  const auto from = std::min(length_, length) / kBlock;
  length_ = length;
  sums_.resize(static_cast<std::size_t>(count_blocks(length)));
  std::vector<std::int64_t> blocks;
  for (const auto offset : offsets)
    if (offset < length) blocks.push_back(offset / kBlock);
  for (auto block = from; block < count_blocks(length); ++block) blocks.push_back(block);
  std::ranges::sort(blocks);
  const auto [last, end] = std::ranges::unique(blocks);
  blocks.erase(last, end);
  for (const auto block : blocks) sum_block(descriptor, block);
}

BlockSums BlockSums::of(int descriptor, std::int64_t length) {
  BlockSums sums;
  sums.renew(descriptor, length, {});
  return sums;
}

namespace {

/// Returns the descriptor with which this process has the file of that name open; kNoDescriptor if there is none.
int find_descriptor(int folder, const std::string& name) {
  struct stat target {};
  if (::fstatat(folder, name.c_str(), &target, AT_SYMLINK_NOFOLLOW) != 0) return kNoDescriptor;
  for (const auto& held : list_folder("/proc/self/fd")) {
    const auto text = held.filename().string();
    int number = kNoDescriptor;
    struct stat found {};
    std::from_chars(text.data(), text.data() + text.size(), number);
    if (::fstat(number, &found) == 0 && found.st_dev == target.st_dev && found.st_ino == target.st_ino) return number;
  }
  return kNoDescriptor;
}

/// Returns the database offsets of the pages in a log. Some of them may come from an older log (SQLite, "WAL-mode File
/// Format").
std::vector<std::int64_t> page_offsets(int log, std::int64_t length) {
  constexpr std::int64_t kFirstFrame = kHeader, kNextFrame = kFrameHeader;
  std::array<unsigned char, 4> number{};
  const auto read = [&](std::int64_t at) { return ::pread(log, number.data(), number.size(), at) == 4; };
  std::vector<std::int64_t> offsets;
  if (!read(kPageSizeAt)) return offsets;
  const std::int64_t page = read_big_endian(number);
  for (auto at = kFirstFrame; page > 0 && at + kNextFrame + page <= length; at += kNextFrame + page)
    if (read(at)) offsets.push_back((std::int64_t{read_big_endian(number)} - 1) * page);
  return offsets;
}

std::int64_t nanoseconds(const timespec& time) {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  return time.tv_sec * kNanoseconds + time.tv_nsec;
}

Interference interference(Interference::Kind kind, bool is_log_only, const std::string& name, const char* what) {
  return {.kind = kind,
          .is_log_only = is_log_only,
          .description = fmt::format("{} was {} by another program while it was being written", name, what)};
}

}  // namespace

/// Reads the identity and state of a file. Omits the change time of the log, because the checksums in the log detect
/// more, and a change of its mode is not an interference.
std::optional<FileWatch::Snapshot> FileWatch::read_state(const File& file) {
  struct stat found {};
  if (::fstat(file.held, &found) != 0) return {};
  return Snapshot{.device = found.st_dev,
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
      {{.name = name, .held = kNoDescriptor, .state = {}, .is_log = false, .content = {}},
       {.name = name + "-wal", .held = kNoDescriptor, .state = {}, .is_log = true, .content = {}}}};
  for (auto& file : files) {
    file.held = find_descriptor(folder->number(), file.name);
    if (file.held == kNoDescriptor)
      return failure(FaultKind::storage, parent + "/" + file.name, "this process has no descriptor for it");
  }
  FileWatch watch(parent, std::move(folder), std::move(files));
  watch.remember();
  return watch;
}

void FileWatch::remember_log() {
  if (const auto now = read_state(files_[1])) files_[1].state = *now;
}

std::vector<std::int64_t> FileWatch::offsets_in_log() const {
  const auto& log = files_[1];
  return page_offsets(log.held, log.state.length);
}

void FileWatch::remember_checkpoint(std::span<const std::int64_t> offsets) {
  remember_log();
  auto& database = files_[0];
  const auto now = read_state(database);
  if (!now || *now == database.state) return;
  database.content.renew(database.held, now->length, offsets);
  database.state = *now;
}

void FileWatch::remember() {
  remember_log();
  auto& database = files_[0];
  const auto now = read_state(database);
  if (!now) return;
  database.content = BlockSums::of(database.held, now->length);
  database.state = *now;
}

std::optional<Interference> FileWatch::check_name(const File& file) const {
  struct stat named {};
  if (::fstatat(folder_->number(), file.name.c_str(), &named, AT_SYMLINK_NOFOLLOW) != 0)
    return interference(Interference::Kind::taken_away, file.is_log, file.name, "removed or moved");
  if (named.st_dev != file.state.device || named.st_ino != file.state.inode)
    return interference(Interference::Kind::taken_away, file.is_log, file.name, "replaced");
  return {};
}

/// Returns whether only the times of the database changed, and then updates the remembered times. Returns false for a
/// log, because after a crash SQLite would drop everything after a write by another program.
bool FileWatch::is_only_touched(File& file, const Snapshot& now) {
  if (file.is_log || now.length != file.state.length || BlockSums::of(file.held, file.state.length) != file.content)
    return false;
  file.state = now;
  return true;
}

std::optional<Interference> FileWatch::check_content(File& file) {
  const auto now = read_state(file);
  if ((now && *now == file.state) || (now && is_only_touched(file, *now))) return {};
  return interference(Interference::Kind::spoiled, file.is_log, file.name,
                      now && now->length < file.state.length ? "cut short" : "written to");
}

/// Checks the database first, because its damage is more serious.
std::optional<Interference> FileWatch::check() {
  if (auto found = check_names()) return found;
  for (auto& file : files_)
    if (auto found = check_content(file)) return found;
  return {};
}

std::optional<Interference> FileWatch::check_folder() const {
  struct stat named {
  }, held{};
  if (::stat(folder_path_.c_str(), &named) != 0) return {};  // path cannot be examined
  if (::fstat(folder_->number(), &held) != 0 || named.st_dev != held.st_dev || named.st_ino != held.st_ino)
    return interference(Interference::Kind::taken_away, false,
                        "the folder " + std::filesystem::path(folder_path_).filename().string(), "replaced");
  return {};
}

std::optional<Interference> FileWatch::check_names() const {
  if (auto found = check_folder()) return found;
  for (const auto& file : files_)
    if (auto found = check_name(file)) return found;
  return {};
}

std::optional<Interference> FileWatch::check_log(std::int64_t frames) const {
  const auto& log = files_[1];
  if (is_log_intact(log.held, frames)) return {};
  return interference(Interference::Kind::spoiled, true, log.name, "written to");
}

std::optional<Interference> FileWatch::check_after_writing(std::int64_t frames) {
  constexpr Duration kLogCheckInterval = std::chrono::milliseconds(500);
  if (auto found = check_names()) return found;
  const auto now = clock_.now().since_start;
  if (log_checked_ && now - *log_checked_ < kLogCheckInterval) return {};
  log_checked_ = now;
  return check_log(frames);
}

std::optional<Interference> FileWatch::check_all(std::int64_t frames) const {
  const auto& database = files_[0];
  if (auto found = check_names()) return found;
  if (::access(folder_path_.c_str(), F_OK) != 0)
    return interference(Interference::Kind::taken_away, false, "the folder " + folder_path_, "removed or moved");
  if (BlockSums::of(database.held, database.state.length) != database.content)
    return interference(Interference::Kind::spoiled, false, database.name, "written to");
  return check_log(frames);
}

}  // namespace gyrotherm::record
