// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/store.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cassert>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/record/alarms.hpp"
#include "acquisition/record/backlog.hpp"
#include "acquisition/record/chain.hpp"
#include "acquisition/record/decision.hpp"
#include "acquisition/record/live_copy.hpp"
#include "acquisition/record/rate_meter.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/record_writer.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/schema.hpp"
#include "acquisition/record/status.hpp"
#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/process.hpp"

namespace gyrotherm::record {
namespace {

/// The event numbers and alarms of an existing record.
struct RestoredState {
  /// The number of the last event.
  std::int64_t last_event{};
  /// Number of event numbers to skip before each entry's events. The record writer uses them for events of its own.
  std::int64_t spare{};
  Alarms alarms{};
};

/// Counts the missing readings of units in a segment that switches the units off.
std::int64_t count_missing_while_off(const Entry& entry, const RunInfo& info) {
  const auto segment = entry.sample && entry.sample->progress ? entry.sample->progress->segment : -1;
  const bool is_known = segment >= 0 && static_cast<std::size_t>(segment) < info.segments.size();
  if (!is_known || !info.segments[static_cast<std::size_t>(segment)].unit.off) return 0;
  return std::ranges::count_if(entry.missing, [&](const Entry::MissingReading& missing) {
    return std::ranges::any_of(info.units, [&](const UnitInfo& unit) { return unit.name == missing.channel; });
  });
}

/// Base class of all stores. Ensures that each slot has exactly one row or belongs to exactly one gap. Maintains the
/// status. Numbers events when they are appended; the record's table uses the same numbers.
class OrderedStore : public Store {
 public:
  Result<void> append(const Sample& sample, std::span<const Event> events) final {
    assert(sample.thermometers.size() == info_.thermometers.size());
    if (auto follows = check_slot_order(sample.slot); !follows) return follows;
    Entry entry = sample_entry(sample, events, info_);
    number_events(entry);
    const auto faults = static_cast<std::int64_t>(entry.missing.size());
    const auto while_off = count_missing_while_off(entry, info_);
    auto kept = entry.events;
    if (auto taken = take(std::move(entry)); !taken) return taken;
    update_alarms(sample.slot, std::move(kept));
    meters_.add(sample);
    last_ = sample.slot;
    status_.faults += faults;
    status_.faults_while_off += while_off;
    update_status(sample);
    return {};
  }

  Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) final {
    assert(first <= last);
    if (auto follows = check_slot_order(first); !follows) return follows;
    if (last > kMaxSlots)
      return failure(FaultKind::storage, fmt::format("slot {}", last), fmt::format("a record holds {}", kMaxSlots));
    auto taken = take(gap_entry(first, last, cause));
    if (taken) last_ = last;
    return taken;
  }

  Result<void> append_event(const Event& event) final {
    auto entry = event_entry(last_, event);
    number_events(entry);
    auto kept = entry.events;
    if (auto taken = take(std::move(entry)); !taken) return taken;
    update_alarms(last_, std::move(kept));
    return {};
  }

  Result<void> append_decision(const Event& decision, std::span<const RunInfo::SegmentInfo> segments) final {
    assert(is_decision(decision) && decision.about.segment == static_cast<int>(info_.segments.size()));
    auto entry = event_entry(last_, decision);
    entry.segments.assign(segments.begin(), segments.end());
    number_events(entry);
    if (auto taken = take(std::move(entry)); !taken) return taken;
    add_block(info_, info_.segments.size(), segments, decision.about.channel);
    status_.segment_count = static_cast<int>(info_.segments.size());
    status_.decision = parse_decision(decision.text);
    return {};
  }
  const Alarms& alarms() const final { return alarms_; }
  void publish(const RunOverview& overview) final { status_.overview = overview; }
  const RunInfo& info() const final { return info_; }

 protected:
  OrderedStore(RunInfo info, RunStatus status, RestoredState counted)
      : info_(std::move(info)),
        meters_(info_.units),
        status_(std::move(status)),
        before_(status_.frames.value_or(FrameCount{})),
        last_(status_.acknowledged),
        last_event_(counted.last_event),
        spare_(counted.spare),
        alarms_(std::move(counted.alarms)) {}

  /// Stores an entry. Entries arrive in order and without missing slots.
  virtual Result<void> take(Entry entry) = 0;

  [[nodiscard]] const RunStatus& status() const { return status_; }
  /// Returns the status with the gyros' rates, for a status file.
  [[nodiscard]] RunStatus status_now() const {
    auto now = status_;
    now.gyro_rates = meters_.rates();
    return now;
  }
  [[nodiscard]] FrameCount frames() const { return status_.frames.value_or(before_); }
  [[nodiscard]] std::int64_t last() const { return last_; }

 private:
  Result<void> check_slot_order(std::int64_t slot) const {
    if (slot == last_ + 1) return {};
    const std::string where = fmt::format("slot {}", slot);
    if (slot <= last_) return failure(FaultKind::storage, where, fmt::format("comes after slot {}", last_));
    return failure(FaultKind::storage, where,
                   fmt::format("slots {} to {} have neither a sample nor a gap", last_ + 1, slot - 1));
  }

  void number_events(Entry& entry) {
    if (!entry.events.empty()) last_event_ += spare_;
    for (Event& event : entry.events) event.number = ++last_event_;
  }

  void update_alarms(std::int64_t slot, std::vector<Event> events) {
    if (events.empty()) return;
    for (Event& event : events) alarms_.update({slot, std::move(event)});
    status_.alarms = alarms_.list();
  }

  void update_status(const Sample& sample) {
    status_.slot = sample.slot;
    status_.slot_since_boot = since_boot();
    status_.slot_in_boot = boot_;
    status_.overview.state = sample.state;
    status_.frames = before_;
    for (const auto& unit : sample.units) {
      status_.frames->seen += unit.frames.seen;
      status_.frames->lost += unit.frames.lost;
      status_.frames->bad += unit.frames.bad;
    }
    set_progress(status_, info_, sample.progress);
    const auto chamber = known_value(sample.chamber);
    status_.chamber_air = chamber ? std::optional(chamber->air) : std::nullopt;
    status_.chamber_set_point = chamber ? celsius_if_known(chamber->set_point.value) : std::nullopt;
    for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
      status_.thermometers[i].second = known_value(sample.thermometers[i]);
  }

  const std::string boot_ = boot_id();
  RunInfo info_;
  RateMeters meters_;
  /// The status of everything appended.
  RunStatus status_;
  /// The frames counted before this program resumed the run.
  FrameCount before_;
  /// The last slot appended.
  std::int64_t last_{};
  std::int64_t last_event_{};
  std::int64_t spare_{};
  Alarms alarms_;
};

/// A store that writes during its calls, without threads.
class InlineStore final : public OrderedStore {
 public:
  InlineStore(RunFile file, const RunStatus& status, RestoredState counted, std::unique_ptr<LiveCopy> copy,
              Duration status_interval, int part)
      : OrderedStore(file.info(), status, std::move(counted)),
        acknowledged_(status.acknowledged),
        status_interval_(status_interval),
        part_(part),
        file_(std::move(file)),
        copy_(std::move(copy)) {}

  Result<std::int64_t> sync() override {
    if (broken_) return failure(*broken_);
    if (std::exchange(batch_open_, false)) {
      const auto done = keep(file_->replace_frames(frames()).and_then([&] { return file_->commit(); }));
      if (!done) return failure(done.error());
      acknowledged_ = last();
      if (copy_) copy_->add(batch_, frames());
      batch_.clear();
      if (const auto folded = keep(file_->checkpoint_log()); !folded) return failure(folded.error());
    }
    write_status_file(false);
    return acknowledged_;
  }

  bool settle(Duration /*longest*/) override {
    pause_ = Deadline(Duration::zero());
    return sync().has_value();
  }

  Result<void> finish() override {
    if (auto synced = sync(); !synced) return failure(synced.error());
    if (auto done = keep(file_->finish()); !done) return done;
    broken_ = Fault{FaultKind::storage, status().path, "the run is finished"};
    if (status().path == kInMemory) return {};
    file_.reset();
    auto closed = close_record(status().path, part_);
    copy_.reset();
    if (closed) write_status_file(true);
    return closed;
  }

  /// Returns the health. The backlog is 0 until the file fails, even if sync() has not been called for some rows.
  StoreHealth health() const override {
    return {.backlog_s = broken_ ? last() - acknowledged_ : 0, .trouble = broken_ ? text(*broken_) : ""};
  }
  Result<Record> read_back() override {
    return file_ ? read_open_record(file_->database()) : Result<Record>(failure(*broken_));
  }

 private:
  Result<void> take(Entry entry) override {
    auto taken = keep(open_batch().and_then([&] { return file_->insert(entry); }));
    if (taken && copy_) batch_.push_back(std::make_shared<const Entry>(std::move(entry)));
    return taken;
  }

  Result<void> open_batch() {
    if (broken_) return failure(*broken_);
    if (batch_open_) return {};
    batch_open_ = true;
    return file_->begin();
  }

  /// Stores the first failure of the file. After it, the file is not written again.
  Result<void> keep(Result<void> result) {
    if (!result && !broken_) {
      broken_ = result.error();
      file_->leave_untouched();
    }
    return result;
  }

  /// Writes the status file if it is due. Ignores a failure, because it must not end the run.
  void write_status_file(bool finished) {
    if (status().path == kInMemory || (!finished && !pause_.has_passed())) return;
    pause_ = Deadline(status_interval_);
    RunStatus now = status_now();
    now.acknowledged = acknowledged_;
    now.finished = finished;
    now.being_written = !finished;
    now.live_copy_trouble = copy_ ? copy_->trouble() : "";
    [[maybe_unused]] const auto written_status = write_status(now);
  }

  std::int64_t acknowledged_{-1};
  Duration status_interval_;
  /// The earliest time of the next update of the status file.
  Deadline pause_{Duration::zero()};
  bool batch_open_{};
  /// The first failure of the file. After it no row is acknowledged.
  std::optional<Fault> broken_;
  int part_{};
  /// Empty after finish(), except in memory.
  std::optional<RunFile> file_;
  std::unique_ptr<LiveCopy> copy_;
  /// Entries of the current transaction. The live copy receives them after the sync.
  std::vector<EntryPointer> batch_;
};

/// The maximum number of rows in one transaction, normally (kMaxRowsAtOnce) and while the disk accepts no rows
/// (kProbeRows).
constexpr std::size_t kMaxRowsAtOnce = 1000;
constexpr std::size_t kProbeRows = 1;
constexpr auto kLongestFinish = std::chrono::seconds(30);
constexpr auto kLongestStop = std::chrono::seconds(10);
/// The longest wait for the status file.
constexpr auto kLongestStatusWait = std::chrono::seconds(1);
/// A write that takes longer than this is reported.
constexpr auto kLongWrite = std::chrono::seconds(3);

using std::chrono::steady_clock;

/// The state that the store shares with its two workers. One worker writes the record. The other writes the status
/// file, which is thus updated even if a write to the record hangs. While the first worker runs, only it uses `writer`.
struct SharedState {
  SharedState(RecordWriter record_writer, RunStatus run_status, std::unique_ptr<LiveCopy> live_copy,
              const StoreOptions& options)
      : retry(options.retry),
        backlog(static_cast<std::size_t>(options.most_rows)),
        status(std::move(run_status)),
        acknowledged(status.acknowledged),
        parts(record_writer.part()),
        copy(std::move(live_copy)),
        writer(std::move(record_writer)) {}

  const Duration retry;
  std::mutex mutex;  ///< guards the members before `writer`
  std::condition_variable work;
  std::condition_variable news;
  std::condition_variable progress;
  Backlog backlog;
  /// Backlog::dropped() when the disk last accepted rows.
  std::size_t dropped_before{};
  /// Status and frame counts of the run when the latest sync was requested.
  RunStatus status;
  FrameCount frames;
  /// True if a sync is requested that has not started.
  bool wanted{};
  /// Start of the sync in progress; absent: no sync is in progress.
  std::optional<steady_clock::time_point> busy_since;
  /// True if the status has changed since the status file was written.
  bool is_status_stale{};
  /// The status file is being written.
  bool is_writing_status{};
  bool stop{};
  bool record_writer_ended{}, status_writer_ended{};
  std::int64_t acknowledged;
  std::string trouble;
  std::string damage;
  /// The number of the last part.
  int parts{};
  /// The paths of the parts begun by this program.
  std::vector<std::string> new_parts;
  /// Null if there is no copy.
  std::unique_ptr<LiveCopy> copy;
  RecordWriter writer;
};

Result<void> write(RecordWriter& writer, std::span<const EntryPointer> entries, const FrameCount& frames) {
  if (entries.empty()) return {};
  auto written = writer.write(entries, frames);
  if (written || RecordWriter::is_temporary(written.error())) return written;
  return writer.write(entries, frames);  // into a new part
}

/// Returns the reason why the disk accepts no rows: its error, or a write that hangs.
std::string disk_trouble(const SharedState& shared) {
  if (!shared.trouble.empty() || !shared.busy_since) return shared.trouble;
  const auto busy_for = steady_clock::now() - *shared.busy_since;
  return busy_for < kLongWrite ? ""
                               : fmt::format("a write to the disk has not returned for {}", format_duration(busy_for));
}

/// Returns the number of seconds up to `last` that are not on the disk.
std::int64_t count_waiting(const SharedState& shared, std::int64_t last) {
  return std::max<std::int64_t>(0, last - shared.acknowledged - shared.backlog.unmeasured());
}

/// Returns the status of the rows on the disk.
RunStatus status_on_disk(const SharedState& shared) {
  RunStatus status = shared.status;
  status.acknowledged = shared.acknowledged;
  status.backlog_s = count_waiting(shared, shared.status.slot);
  status.storage_trouble = disk_trouble(shared);
  status.record_damage = shared.damage;
  status.live_copy_trouble = shared.copy ? shared.copy->trouble() : "";
  status.parts.insert(status.parts.end(), shared.new_parts.begin(), shared.new_parts.end());
  return status;
}

/// Executes one transaction. The caller must hold `lock`, which is released during the write.
void write_once(SharedState& shared, std::unique_lock<std::mutex>& lock) {
  shared.wanted = false;
  shared.busy_since = steady_clock::now();
  const auto most = shared.trouble.empty() ? kMaxRowsAtOnce : kProbeRows;
  const auto batch = shared.backlog.take(most);
  const auto frames = shared.frames;
  lock.unlock();
  const auto written = write(shared.writer, batch, frames);
  lock.lock();
  if (written) {
    shared.backlog.acknowledge();
    shared.dropped_before = shared.backlog.dropped();
    if (shared.copy) shared.copy->add(batch, frames);
  } else {
    shared.backlog.put_back();
  }
  shared.trouble = written ? "" : text(written.error());
  shared.acknowledged = shared.writer.acknowledged();
  if (const int part = shared.writer.part(); part != std::exchange(shared.parts, part))
    shared.new_parts.push_back(part_path(shared.status.path, part));
  shared.damage = shared.writer.damage();
  shared.wanted = shared.wanted || (written && batch.size() == most);
  shared.busy_since.reset();
  shared.is_status_stale = true;
  shared.news.notify_one();
  shared.progress.notify_all();
}

/// Runs the worker that writes the record.
void run_record_writer(SharedState& shared) {
  block_signals();
  std::unique_lock lock(shared.mutex);
  while (!shared.stop || (shared.wanted && shared.trouble.empty())) {
    if (!shared.trouble.empty()) {
      shared.work.wait_for(lock, shared.retry, [&] { return shared.stop; });
      if (shared.stop) break;
    } else {
      shared.work.wait(lock, [&] { return shared.stop || shared.wanted; });
      if (!shared.wanted) break;
    }
    write_once(shared, lock);
  }
  shared.record_writer_ended = true;
  shared.progress.notify_all();
}

/// Runs the worker that writes the status file.
void run_status_writer(SharedState& shared) {
  block_signals();
  std::unique_lock lock(shared.mutex);
  for (;;) {
    shared.news.wait(lock, [&] { return shared.stop || shared.is_status_stale; });
    if (!shared.is_status_stale) break;
    shared.is_status_stale = false;
    shared.is_writing_status = true;
    const auto status = status_on_disk(shared);
    lock.unlock();
    [[maybe_unused]] const auto written_status = write_status(status);  // a failure is ignored
    lock.lock();
    shared.is_writing_status = false;
    shared.progress.notify_all();
  }
  shared.status_writer_ended = true;
  shared.progress.notify_all();
}

class BackgroundStore final : public OrderedStore {
 public:
  BackgroundStore(RecordWriter writer, RunInfo info, const RunStatus& status, Alarms alarms,
                  std::unique_ptr<LiveCopy> copy, const StoreOptions& options)
      : OrderedStore(std::move(info), status,
                     {.last_event = writer.last_event(), .spare = 1, .alarms = std::move(alarms)}),
        shared_(std::make_shared<SharedState>(std::move(writer), status, std::move(copy), options)) {}
  ~BackgroundStore() override {
    if (stop()) end_copy();
  }
  BackgroundStore(const BackgroundStore&) = delete;
  BackgroundStore& operator=(const BackgroundStore&) = delete;

  Result<std::int64_t> sync() override {
    if (finished_) return failure(FaultKind::storage, status().path, "the run is finished");
    const std::lock_guard lock(shared_->mutex);
    shared_->status = status_now();
    shared_->frames = frames();
    shared_->wanted = true;
    shared_->work.notify_one();
    shared_->is_status_stale = shared_->is_status_stale || shared_->busy_since;  // otherwise write_once() sets it
    shared_->news.notify_one();
    return shared_->acknowledged;
  }

  bool settle(Duration longest) override {
    if (!sync()) return true;
    if (!worker_.joinable()) {
      while (shared_->wanted) attend();
      return shared_->backlog.empty();
    }
    std::unique_lock lock(shared_->mutex);
    const auto written = [this] { return shared_->backlog.empty() && !shared_->wanted && !shared_->busy_since; };
    if (!shared_->progress.wait_for(lock, longest, written)) return false;
    shared_->progress.wait_for(lock, kLongestStatusWait,
                               [this] { return !shared_->is_status_stale && !shared_->is_writing_status; });
    return true;
  }

  Result<void> finish() override {
    if (!settle(kLongestFinish)) {
      const auto now = health();
      return failure(FaultKind::storage, status().path,
                     fmt::format("{} s are not on the disk: {}", now.backlog_s, now.trouble));
    }
    if (finished_) return failure(FaultKind::storage, status().path, "the run is finished");
    const bool is_working = worker_.joinable();
    if (!stop()) return failure(FaultKind::storage, status().path, "a write to the disk does not return");
    finished_ = true;
    const auto done = shared_->writer.finish();
    end_copy();
    if (!done) return done;
    if (is_working && !status_writer_hangs_) write_final_status();
    const auto& writer = shared_->writer;
    if (!writer.is_damaged()) return {};
    return failure(FaultKind::storage, status().path,
                   fmt::format("{}; {} in {}", writer.damage(),
                               writer.from() == 0 ? std::string("the record is complete")
                                                  : fmt::format("all seconds from {} on are", writer.from()),
                               part_path(status().path, writer.part())));
  }

  StoreHealth health() const override {
    const std::lock_guard lock(shared_->mutex);
    return {.backlog_s = count_waiting(*shared_, last()),
            .rows_dropped = shared_->backlog.dropped() > shared_->dropped_before,
            .trouble = disk_trouble(*shared_),
            .parts = shared_->parts,
            .damage = shared_->damage};
  }

  Result<Record> read_back() override {
    return failure(FaultKind::storage, status().path, "cannot be read back while its writer thread is running");
  }

  void start_workers() {
    worker_ = std::thread([shared = shared_] { run_record_writer(*shared); });
    status_writer_ = std::thread([shared = shared_] { run_status_writer(*shared); });
  }
  /// Executes one transaction of the record writer in the caller's thread, if one is due.
  void attend() {
    std::unique_lock lock(shared_->mutex);
    if (shared_->wanted || !shared_->trouble.empty()) write_once(*shared_, lock);
  }

 private:
  Result<void> take(Entry entry) override {
    if (finished_) return failure(FaultKind::storage, status().path, "the run is finished");
    const std::lock_guard lock(shared_->mutex);
    shared_->backlog.push(std::move(entry));
    return {};
  }

  void end_copy() {
    std::unique_ptr<LiveCopy> copy;  // destroyed after the lock is released
    const std::lock_guard lock(shared_->mutex);
    copy = std::move(shared_->copy);
  }

  void write_final_status() const {
    auto written_status = status_on_disk(*shared_);
    written_status.finished = true;
    written_status.being_written = false;
    (void)write_status(written_status);
  }

  /// Ends both workers. Returns false if the record worker hangs. A hang of the status worker does not prevent the end
  /// of a run.
  bool stop() {
    if (!worker_.joinable()) return true;
    {
      const std::lock_guard lock(shared_->mutex);
      shared_->stop = true;
    }
    shared_->work.notify_one();
    shared_->news.notify_one();
    const bool written = await(kLongestStop, &SharedState::record_writer_ended, worker_);
    status_writer_hangs_ = !await(kLongestStatusWait, &SharedState::status_writer_ended, status_writer_);
    if (status_writer_hangs_) {
      const std::lock_guard lock(shared_->mutex);
      shared_->is_status_stale = false;  // if it recovers, it writes nothing
    }
    return written;
  }

  /// Waits for a thread. Abandons it and returns false if it hangs.
  [[nodiscard]] bool await(Duration longest, bool SharedState::*end, std::thread& thread) {
    {
      std::unique_lock lock(shared_->mutex);
      if (!shared_->progress.wait_for(lock, longest, [&] { return *shared_.*end; })) {
        thread.detach();
        return false;
      }
    }
    thread.join();
    return true;
  }

  std::shared_ptr<SharedState> shared_;
  std::thread worker_, status_writer_;
  bool status_writer_hangs_{};  ///< the status writer was abandoned
  bool finished_{};
};

}  // namespace

AttendedStore make_attended_store(RecordWriter writer, RunInfo info, const RunStatus& status, Alarms alarms,
                                  const StoreOptions& options) {
  auto store = std::make_unique<BackgroundStore>(std::move(writer), std::move(info), status, std::move(alarms), nullptr,
                                                 options);
  const auto attend = [background = store.get()] { background->attend(); };
  return {std::move(store), attend};
}

namespace {

Result<std::unique_ptr<Store>> open_store(RunFile file, RunStatus status, RestoredState counted,
                                          std::unique_ptr<LiveCopy> copy, const StoreOptions& options, int part) {
  status.pid = ::getpid();
  status.being_written = true;
  status.ended_by.clear();
  const bool in_memory = status.path == kInMemory;
  if (!in_memory) (void)write_status(status);  // a failure is ignored
  if (in_memory || !options.background)
    return std::make_unique<InlineStore>(std::move(file), status, std::move(counted),
                                         in_memory ? nullptr : std::move(copy), options.status_interval, part);
  RunInfo info = file.info();
  RecordWriter writer(std::move(file), status.path,
                      {.most_rows = static_cast<std::size_t>(options.most_rows),
                       .part = part,
                       .last_slot = status.acknowledged,
                       .last_event = counted.last_event});
  auto store = std::make_unique<BackgroundStore>(std::move(writer), std::move(info), status, std::move(counted.alarms),
                                                 std::move(copy), options);
  store->start_workers();
  return store;
}

}  // namespace

Result<std::unique_ptr<Store>> Store::create(const std::string& path, const RunInfo& info,
                                             const StoreOptions& options) {
  auto file = RunFile::create(path, info);
  if (!file) return failure(file.error());
  if (auto proved = file->test_write(); !proved) {
    file = failure(proved.error());
    remove_record(path);
    return failure(proved.error());
  }
  if (path != kInMemory) ::unlink(manifest_path(path).c_str());  // manifest of an earlier record
  auto copy = options.live_copy ? std::make_unique<LiveCopy>(path, info, *options.live_copy) : nullptr;
  return open_store(std::move(*file), make_first_status(path, info), {}, std::move(copy), options, 1);
}

Result<std::unique_ptr<Store>> Store::reopen(const std::string& path, const StoreOptions& options) {
  const auto files = find_record_files(path);
  if (!files) return failure(files.error());
  auto alarms = read_record_alarms(*files);  // before the record changes
  if (!alarms) return failure(alarms.error());
  const auto last_event = read_last_event_number(*files);
  if (!last_event) return failure(last_event.error());
  const auto before = read_status(*files);
  const auto last_file = read_status_file_if_any(path);
  std::unique_ptr<LiveCopy> copy;
  if (options.live_copy)
    if (const auto info = read_info(*files); info)
      copy = LiveCopy::for_existing_record(*files, *info, *options.live_copy);
  const auto& last = files->parts.back();
  auto file = RunFile::reopen(last.path);
  if (!file) return failure(file.error());
  auto status = read_stored_status(file->database(), path);
  if (!status) return failure(status.error());
  status->alarms = alarms->list();
  for (const auto& part : files->parts)
    if (part.path != path) status->parts.push_back(part.path);
  if (before) {  // all files
    status->faults = before->faults;
    status->faults_while_off = before->faults_while_off;
  }
  // The new status file describes the same sample as the last one.
  if (last_file && last_file->id == status->id) {
    status->slot_since_boot = last_file->slot_since_boot - std::chrono::seconds(last_file->slot - status->slot);
    status->slot_in_boot = last_file->slot_in_boot;
  }
  if (auto proved = file->test_write(); !proved) return failure(proved.error());
  return open_store(std::move(*file), std::move(*status), {.last_event = *last_event, .alarms = std::move(*alarms)},
                    std::move(copy), options, last.continuation.part);
}

void remove_record(const std::string& path) {
  for (const char* suffix : {"", "-wal", "-journal", "-shm"}) ::unlink((path + suffix).c_str());
  ::unlink(status_path(path).c_str());
}

}  // namespace gyrotherm::record
