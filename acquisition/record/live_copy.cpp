// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/live_copy.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <filesystem>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/record/record_files.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/schema.hpp"
#include "core/file.hpp"
#include "core/process.hpp"

namespace gyrotherm::record {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

constexpr auto kLongestShutdown = std::chrono::seconds(2);
constexpr auto kRetryPause = std::chrono::seconds(1);
/// The copy is removed if less than the reserved space divided by this number is left.
constexpr std::uintmax_t kScarceSpaceDivisor = 8;
constexpr std::int64_t kPageBytes = 4096;

int next_number(int number) { return number % kHighestCopyNumber + 1; }

/// Removes the files of all copies except the file with the number `but`. Returns the highest number removed; 0 if
/// there is none.
int remove_files(const std::string& link, int but) {
  int highest = 0;
  for (const auto& entry : list_folder(parent_folder(link))) {
    const auto number = live_copy_number(entry.filename().string(), name_in_folder(link));
    if (!number || *number == but) continue;
    highest = std::max(highest, *number);
    ::unlink(entry.c_str());
  }
  return highest;
}

/// Returns the free bytes of the file's disk; nothing if they are unknown.
std::optional<std::uintmax_t> free_space(const std::string& path) {
  struct statvfs disk {};
  if (::statvfs(parent_folder(path).c_str(), &disk) != 0 || disk.f_blocks == 0) return {};
  return std::uintmax_t{disk.f_bavail} * disk.f_frsize;
}

/// Points the link at the file of a copy. Fails if a file with the name of the link exists and is not a symbolic link.
Result<void> point_link_at(const std::string& link, const std::string& target) {
  std::error_code ignored;
  const auto there = fs::symlink_status(link, ignored);
  if (fs::exists(there) && !fs::is_symlink(there))
    return failure(FaultKind::storage, link, "exists and is not a live copy; it is not replaced");
  const auto made = link + ".new";
  ::unlink(made.c_str());
  if (::symlink(name_in_folder(target).c_str(), made.c_str()) != 0 || ::rename(made.c_str(), link.c_str()) != 0)
    return failure(FaultKind::storage, link, std::strerror(errno));
  return {};
}

/// Copies all rows of a record that is not being written, file by file. A part may repeat rows of the part before it;
/// they are copied once.
Result<void> copy_record(RunFile& copy, const RecordFiles& files) {
  FrameCount frames;
  for (std::size_t i = 0; i < files.parts.size(); ++i) {
    auto part = open_part(files.parts[i]);
    if (!part && i + 1 < files.parts.size()) continue;
    if (!part) return failure(part.error());
    const auto end = i + 1 < files.parts.size() ? files.parts[i + 1].continuation.from : kMaxSlots + 1;
    if (auto copied = copy.copy_rows(*part, end); !copied) return copied;
    const auto count = [&](const char* what) {
      return static_cast<std::uint64_t>(part->query_integer(fmt::format("SELECT {} FROM frames", what), 0).value_or(0));
    };
    frames = {.seen = count("seen"), .lost = count("lost"), .bad = count("bad")};
  }
  return copy.replace_frames(frames);
}

}  // namespace

/// The state that the copy shares with its worker. Once the worker runs, only it accesses the file.
struct LiveCopy::Worker {
  Worker(const std::string& record, RunInfo run_info, const LiveCopyOptions& copy_options)
      : link(live_copy_path(record)), info(std::move(run_info)), options(copy_options) {}

  const std::string link;
  const RunInfo info;
  const LiveCopyOptions options;

  std::mutex mutex;  ///< guards the members before `file`
  std::condition_variable news, progress;
  std::deque<EntryPointer> waiting;
  FrameCount frames;
  std::string trouble;
  bool stop{}, ended{};
  bool given_up{};  ///< the copy has ended

  std::optional<RunFile> file;
  /// The highest number among the files that a dead program left.
  int left_behind{};
  /// The number of the present file, and the time when it was begun.
  int number{};
  steady_clock::time_point begun_at{};
  /// The time since which writing the file has failed.
  std::optional<steady_clock::time_point> locked;
  /// No further attempt can succeed.
  bool is_lost{};
  std::thread thread;

  /// Ends the copy. Call it with the lock held, or before the worker runs.
  void give_up(std::string why) {
    given_up = true;
    trouble = std::move(why);
    waiting.clear();
  }
  std::string file_path(int which) const { return fmt::format("{}.{}", link, which); }
  bool is_in_place() const;
  void remove_left_behind();
  Result<void> check_space(std::uintmax_t bytes);
  Result<void> begin();
  Result<void> begin_with_record(const RecordFiles& files);
  Result<void> open_to_readers(RunFile made, int file_number);
  bool is_damaged();
  Result<void> begin_new_file();
  Result<void> insert_all(std::span<const EntryPointer> entries, const FrameCount& count);
  Result<void> prepare_to_write();
  Result<void> write(std::span<const EntryPointer> entries, const FrameCount& count);
  void await_age(std::unique_lock<std::mutex>& lock);
  void work();
  void remove_copy();
};

/// Returns whether the link exists and points at the present file. Another program may have removed the link.
bool LiveCopy::Worker::is_in_place() const {
  std::error_code ignored;
  return fs::read_symlink(link, ignored) == name_in_folder(file_path(number));
}

/// Removes older copies. They belong to another run, or to an earlier state of this one. Call it before the worker
/// runs.
void LiveCopy::Worker::remove_left_behind() {
  if (is_live_copy(link)) ::unlink(link.c_str());
  left_behind = remove_files(link, 0);
}

/// Fails if `bytes` more on the disk would use space that is reserved for the record.
Result<void> LiveCopy::Worker::check_space(std::uintmax_t bytes) {
  const auto free = free_space(link);
  if (!free || *free >= bytes + options.left_free) return {};
  is_lost = *free < options.left_free / kScarceSpaceDivisor;
  constexpr unsigned kMebi = 20;
  return failure(FaultKind::storage, link,
                 fmt::format("its disk has {} MiB free, and the last {} MiB are reserved for the record",
                             *free >> kMebi, options.left_free >> kMebi));
}

/// Makes a file the present copy, even if the link cannot be set. prepare_to_write() then tries again to set it.
Result<void> LiveCopy::Worker::open_to_readers(RunFile made, int file_number) {
  begun_at = steady_clock::now();
  if (options.most_pages > 0)
    if (auto set = made.database().execute(fmt::format("PRAGMA max_page_count = {}", options.most_pages)); !set)
      return set;
  if (auto shared = made.share(); !shared) return shared;
  file.reset();  // ends statements before their connection
  file.emplace(std::move(made));
  number = file_number;
  locked.reset();
  auto pointed = point_link_at(link, file_path(number));
  if (pointed) remove_files(link, number);
  return pointed;
}

Result<void> LiveCopy::Worker::begin() {
  begun_at = steady_clock::now();
  const int next = next_number(std::max(left_behind, remove_files(link, 0)));
  auto made = RunFile::create_copy(file_path(next), info);
  return made ? open_to_readers(std::move(*made), next) : failure(made.error());
}

/// Begins a copy with all rows of the record. Call it before the worker runs.
Result<void> LiveCopy::Worker::begin_with_record(const RecordFiles& files) {
  std::error_code unknown;
  const auto size = fs::file_size(files.path, unknown);
  if (auto space = check_space(unknown ? 0 : size); !space) return space;
  const int next = next_number(std::max(left_behind, remove_files(link, 0)));
  auto made = RunFile::create_copy(file_path(next), info);
  if (!made) return failure(made.error());
  const auto filled =
      made->begin().and_then([&] { return copy_record(*made, files); }).and_then([&] { return made->commit(); });
  return filled ? open_to_readers(std::move(*made), next) : filled;
}

/// Returns whether the file is damaged. Its rows then cannot be copied into a new file. They cannot be read from the
/// record either, because only the writer of the record may open it.
bool LiveCopy::Worker::is_damaged() {
  const auto verdict = file->database().query_text("PRAGMA quick_check(1)");
  return verdict ? *verdict != "ok" : !is_locked(verdict.error()) && !is_full(verdict.error());
}

/// Copies all rows into a new file, which becomes the copy. Readers of the previous file can keep it open.
Result<void> LiveCopy::Worker::begin_new_file() {
  begun_at = steady_clock::now();
  std::error_code unknown;
  const auto size = fs::file_size(file_path(number), unknown);
  if (auto space = check_space(unknown ? 0 : 2 * size); !space)
    return failure(FaultKind::storage, link, "must be restarted: " + space.error().what);
  const int next = next_number(number);
  for (const char* suffix : {"", "-wal", "-shm"}) ::unlink((file_path(next) + suffix).c_str());
  if (auto made = make_new_file(file_path(next)); !made) return made;
  auto copied = file->copy_to(file_path(next));
  if (!copied) is_lost = is_damaged();
  auto made = copied.and_then([&] { return RunFile::open_copy(file_path(next)); });
  return made ? open_to_readers(std::move(*made), next) : failure(made.error());
}

Result<void> LiveCopy::Worker::insert_all(std::span<const EntryPointer> entries, const FrameCount& count) {
  auto done = file->begin();
  for (const auto& entry : entries)
    if (done) done = file->insert(*entry);
  return done.and_then([&] { return file->replace_frames(count); }).and_then([&] { return file->commit(); });
}

/// Ensures that a file can take the next rows: it exists, the link points at it, and its log is not too long.
Result<void> LiveCopy::Worker::prepare_to_write() {
  const bool is_resting = steady_clock::now() - begun_at < options.rest && begun_at != steady_clock::time_point();
  if (!file) return is_resting ? failure(FaultKind::storage, link, "cannot be started") : begin();
  std::error_code ignored;
  const bool is_gone = !fs::exists(file_path(number), ignored);
  const bool is_long = file->database().log_pages() * kPageBytes > options.longest_log;
  if (is_gone && is_resting) return failure(FaultKind::storage, link, "its file was removed");
  if (is_gone || is_long) return begin_new_file();
  return is_in_place() ? Result<void>{} : point_link_at(link, file_path(number));
}

/// Writes all entries, or none.
Result<void> LiveCopy::Worker::write(std::span<const EntryPointer> entries, const FrameCount& count) {
  if (auto space = check_space(0); !space) return space;
  if (auto ready = prepare_to_write(); !ready) return ready;
  if (auto done = insert_all(entries, count); !done) {
    (void)file->roll_back();
    const auto now = steady_clock::now();
    if (!locked) locked = now;
    const bool is_transient =
        is_full(done.error()) || now - *locked < options.longest_locked || now - begun_at < options.rest;
    if (is_transient) return done;
    if (auto again = begin_new_file(); !again) return again;
    if (done = insert_all(entries, count); !done) return (void)file->roll_back(), done;
  }
  locked.reset();
  // Reads the file, which updates the index of the log. A reader without write access to the index sees the state at
  // the last such read.
  (void)file->database().query_integer("SELECT seen FROM frames", 0);
  (void)file->checkpoint_log();
  return {};
}

void LiveCopy::Worker::await_age(std::unique_lock<std::mutex>& lock) {
  news.wait_for(lock, options.begins_after, [&] { return stop; });
}

void LiveCopy::Worker::work() {
  block_signals();
  std::unique_lock lock(mutex);
  await_age(lock);
  for (;;) {
    news.wait(lock, [&] { return stop || given_up || !waiting.empty(); });
    if (stop || given_up) break;
    const std::vector<EntryPointer> batch(waiting.begin(), waiting.end());
    const auto count = frames;
    lock.unlock();
    const auto written = write(batch, count);
    lock.lock();
    if (written && !given_up) waiting.erase(waiting.begin(), waiting.begin() + std::ssize(batch));
    if (!given_up) trouble = written ? "" : text(written.error());
    if (!given_up && is_lost) give_up("the live copy has ended: " + trouble);
    news.wait_for(lock, written ? options.pause : Duration(kRetryPause), [&] { return stop; });
  }
  lock.unlock();
  remove_copy();
  lock.lock();
  ended = true;
  progress.notify_all();
}

/// Removes the copy, including unfinished files.
void LiveCopy::Worker::remove_copy() {
  if (number > 0 && is_in_place()) ::unlink(link.c_str());
  file.reset();
  remove_files(link, 0);
}

LiveCopy::LiveCopy(const std::string& record_path, const RunInfo& info, const LiveCopyOptions& options)
    : worker_(std::make_shared<Worker>(record_path, info, options)) {
  worker_->remove_left_behind();
  start();
}

std::unique_ptr<LiveCopy> LiveCopy::for_existing_record(const RecordFiles& files, const RunInfo& info,
                                                        const LiveCopyOptions& options) {
  std::unique_ptr<LiveCopy> copy(new LiveCopy(std::make_shared<Worker>(files.path, info, options)));
  copy->worker_->remove_left_behind();
  const auto begun = copy->worker_->begin_with_record(files);
  if (begun) {
    copy->start();
  } else {
    copy->worker_->remove_copy();
    copy->worker_->give_up(text(begun.error()));
  }
  return copy;
}

LiveCopy::LiveCopy(std::shared_ptr<Worker> worker) : worker_(std::move(worker)) {}

void LiveCopy::start() {
  worker_->thread = std::thread([worker = worker_] { worker->work(); });
}

LiveCopy::~LiveCopy() {
  auto& thread = worker_->thread;
  if (!thread.joinable()) return;
  bool ended{};
  {
    std::unique_lock lock(worker_->mutex);
    worker_->stop = true;
    worker_->news.notify_all();
    ended = worker_->progress.wait_for(lock, kLongestShutdown, [&] { return worker_->ended; });
  }
  ended ? thread.join() : thread.detach();
}

void LiveCopy::add(std::span<const EntryPointer> entries, const FrameCount& frames) {
  if (entries.empty()) return;
  const std::lock_guard lock(worker_->mutex);
  if (worker_->given_up) return;
  worker_->waiting.insert(worker_->waiting.end(), entries.begin(), entries.end());
  worker_->frames = frames;
  if (worker_->waiting.size() > worker_->options.most_rows)
    worker_->give_up(fmt::format("the live copy has ended, because more rows are waiting than memory can hold: {}",
                                 worker_->trouble));
  worker_->news.notify_all();
}

std::string LiveCopy::trouble() const {
  const std::lock_guard lock(worker_->mutex);
  return worker_->trouble;
}

}  // namespace gyrotherm::record
