#include "acquisition/record/background_store.hpp"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/record/backlog.hpp"
#include "acquisition/record/ordered_store.hpp"
#include "acquisition/record/record.hpp"
#include "core/clock.hpp"
#include "core/process.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kMostAtOnce = 1000;  ///< rows of one transaction
constexpr std::size_t kProbe = 1;          ///< … while the disk takes nothing
constexpr auto kLongestFinish = std::chrono::seconds(30);
constexpr auto kLongestFarewell = std::chrono::seconds(10);
constexpr auto kLongestTelling = std::chrono::seconds(1);  ///< of the status file, which is a courtesy
constexpr auto kLongWrite = std::chrono::seconds(3);       ///< one that takes longer is trouble

using std::chrono::steady_clock;

/// What the store and its two workers share: the one writes the record, the other one the status file, so that it goes
/// on telling when a write to the record does not come back. Only the first touches the writer, until it has ended.
struct SharedState {
  SharedState(RecordWriter record_writer, RunStatus run_status, const StoreOptions& options)
      : retry(options.retry),
        backlog(static_cast<std::size_t>(options.most_rows)),
        status(std::move(run_status)),
        acknowledged(status.acknowledged),
        writer(std::move(record_writer)) {}

  const Duration retry;
  std::mutex mutex;  ///< of everything down to the writer
  std::condition_variable work;
  std::condition_variable news;
  std::condition_variable progress;
  Backlog backlog;
  std::size_t dropped_before{};                        ///< rows, when the disk last took something
  RunStatus status;                                    ///< as of the last sync
  FrameCount frames;                                   ///< likewise
  bool wanted{};                                       ///< a sync was asked for
  std::optional<steady_clock::time_point> busy_since;  ///< … and is being carried out
  bool untold{};                                       ///< there is more than the status file says
  bool telling{};                                      ///< it is being written
  bool stop{};
  bool writing_ended{}, telling_ended{};
  std::int64_t acknowledged;
  std::string trouble;
  std::string damage;
  int parts{1};
  RecordWriter writer;
};

Result<void> write(RecordWriter& writer, std::span<const EntryPointer> entries, const FrameCount& frames) {
  if (entries.empty()) return {};
  auto written = writer.write(entries, frames);
  if (written || RecordWriter::will_pass(written.error())) return written;
  return writer.write(entries, frames);  // into a new part
}

/// Why the disk takes no rows: it said so, or says nothing.
std::string trouble_of(const SharedState& desk) {
  if (!desk.trouble.empty() || !desk.busy_since) return desk.trouble;
  const auto busy_for = steady_clock::now() - *desk.busy_since;
  return busy_for < kLongWrite ? "" : fmt::format("a write has not come back for {}", spoken(busy_for));
}

/// The status as the disk has it.
RunStatus told_of(const SharedState& desk) {
  RunStatus status = desk.status;
  status.acknowledged = desk.acknowledged;
  status.backlog_s = std::max(desk.status.slot, desk.acknowledged) - desk.acknowledged;
  status.storage_trouble = trouble_of(desk);
  status.record_damage = desk.damage;
  for (int part = 2; part <= desk.parts; ++part) status.parts.push_back(part_path(status.path, part));
  return status;
}

/// One transaction; called and returns with the lock.
void write_once(SharedState& desk, std::unique_lock<std::mutex>& lock) {
  desk.wanted = false;
  desk.busy_since = steady_clock::now();
  const auto most = desk.trouble.empty() ? kMostAtOnce : kProbe;
  const auto batch = desk.backlog.take(most);
  const auto frames = desk.frames;
  lock.unlock();
  const auto written = write(desk.writer, batch, frames);
  lock.lock();
  if (written) {
    desk.backlog.acknowledge();
    desk.dropped_before = desk.backlog.dropped();
  } else {
    desk.backlog.put_back();
  }
  desk.trouble = written ? "" : text(written.error());
  desk.acknowledged = desk.writer.acknowledged();
  desk.parts = desk.writer.part();
  desk.damage = desk.writer.damage();
  desk.wanted = desk.wanted || (written && batch.size() == most);
  desk.busy_since.reset();
  desk.untold = true;
  desk.news.notify_one();
  desk.progress.notify_all();
}

/// The work of the worker that writes the record.
void serve(SharedState& desk) {
  block_signals();
  std::unique_lock lock(desk.mutex);
  while (!desk.stop || (desk.wanted && desk.trouble.empty())) {
    if (!desk.trouble.empty()) {
      desk.work.wait_for(lock, desk.retry, [&] { return desk.stop; });
      if (desk.stop) break;
    } else {
      desk.work.wait(lock, [&] { return desk.stop || desk.wanted; });
      if (!desk.wanted) break;
    }
    write_once(desk, lock);
  }
  desk.writing_ended = true;
  desk.progress.notify_all();
}

/// The work of the one that writes the status file.
void tell(SharedState& desk) {
  block_signals();
  std::unique_lock lock(desk.mutex);
  for (;;) {
    desk.news.wait(lock, [&] { return desk.stop || desk.untold; });
    if (!desk.untold) break;
    desk.untold = false;
    desk.telling = true;
    const auto status = told_of(desk);
    lock.unlock();
    [[maybe_unused]] const auto told = write_status(status);  // a courtesy
    lock.lock();
    desk.telling = false;
    desk.progress.notify_all();
  }
  desk.telling_ended = true;
  desk.progress.notify_all();
}

class BackgroundStore final : public OrderedStore {
 public:
  BackgroundStore(RecordWriter writer, RunInfo info, const RunStatus& status, const StoreOptions& options)
      : OrderedStore(std::move(info), status),
        desk_(std::make_shared<SharedState>(std::move(writer), status, options)) {}
  ~BackgroundStore() override { stop(); }
  BackgroundStore(const BackgroundStore&) = delete;
  BackgroundStore& operator=(const BackgroundStore&) = delete;

  Result<std::int64_t> sync() override;
  bool settle(Duration longest) override;
  Result<void> finish() override;
  StoreHealth health() const override;
  Result<Record> read_back() override;

  void start_workers() {
    worker_ = std::thread([desk = desk_] { serve(*desk); });
    status_writer_ = std::thread([desk = desk_] { tell(*desk); });
  }
  /// Instead of the workers.
  void attend();

 private:
  Result<void> take(Entry entry) override;
  bool stop();
  [[nodiscard]] bool await(Duration longest, bool SharedState::*end, std::thread& thread);

  std::shared_ptr<SharedState> desk_;
  std::thread worker_, status_writer_;
  bool finished_{};
};

Result<void> BackgroundStore::take(Entry entry) {
  if (finished_) return failure(FaultKind::storage, status().path, "the run is finished");
  const std::lock_guard lock(desk_->mutex);
  desk_->backlog.push(std::move(entry));
  return {};
}

Result<std::int64_t> BackgroundStore::sync() {
  if (finished_) return failure(FaultKind::storage, status().path, "the run is finished");
  const std::lock_guard lock(desk_->mutex);
  desk_->status = status();
  desk_->frames = frames();
  desk_->wanted = true;
  desk_->work.notify_one();
  desk_->untold = desk_->untold || desk_->busy_since;  // otherwise that is told when it is done
  desk_->news.notify_one();
  return desk_->acknowledged;
}

void BackgroundStore::attend() {
  std::unique_lock lock(desk_->mutex);
  if (desk_->wanted || !desk_->trouble.empty()) write_once(*desk_, lock);
}

bool BackgroundStore::settle(Duration longest) {
  if (!sync()) return true;
  if (!worker_.joinable()) {
    while (desk_->wanted) attend();
    return desk_->backlog.empty();
  }
  std::unique_lock lock(desk_->mutex);
  const auto written = [this] { return desk_->backlog.empty() && !desk_->wanted && !desk_->busy_since; };
  if (!desk_->progress.wait_for(lock, longest, written)) return false;
  desk_->progress.wait_for(lock, kLongestTelling, [this] { return !desk_->untold && !desk_->telling; });
  return true;
}

/// A thread that hangs in the disk is left behind there; false then.
bool BackgroundStore::await(Duration longest, bool SharedState::*end, std::thread& thread) {
  {
    std::unique_lock lock(desk_->mutex);
    if (!desk_->progress.wait_for(lock, longest, [&] { return *desk_.*end; })) {
      thread.detach();
      return false;
    }
  }
  thread.join();
  return true;
}

/// Ends both workers; false if one hangs.
bool BackgroundStore::stop() {
  if (!worker_.joinable()) return true;
  {
    const std::lock_guard lock(desk_->mutex);
    desk_->stop = true;
  }
  desk_->work.notify_one();
  desk_->news.notify_one();
  const bool written = await(kLongestFarewell, &SharedState::writing_ended, worker_);
  const bool told = await(kLongestTelling, &SharedState::telling_ended, status_writer_);
  return written && told;
}

Result<void> BackgroundStore::finish() {
  if (!settle(kLongestFinish)) {
    const auto now = health();
    return failure(FaultKind::storage, status().path,
                   fmt::format("{} s are not on the disk: {}", now.backlog_s, now.trouble));
  }
  if (finished_) return failure(FaultKind::storage, status().path, "the run is finished");
  const bool is_working = worker_.joinable();
  if (!stop()) return failure(FaultKind::storage, status().path, "a write does not come back from the disk");
  finished_ = true;
  if (auto done = desk_->writer.finish(); !done) return done;
  auto told = told_of(*desk_);
  told.finished = true;
  told.being_written = false;
  if (is_working) (void)write_status(told);
  const auto& writer = desk_->writer;
  if (!writer.is_spoiled()) return {};
  return failure(FaultKind::storage, status().path,
                 fmt::format("{}; {} in {}", writer.damage(),
                             writer.from() == 0 ? std::string("the record is complete")
                                                : fmt::format("all seconds from {} on are", writer.from()),
                             part_path(status().path, writer.part())));
}

StoreHealth BackgroundStore::health() const {
  const std::lock_guard lock(desk_->mutex);
  return {.backlog_s = last() - desk_->acknowledged,
          .rows_dropped = desk_->backlog.dropped() > desk_->dropped_before,
          .trouble = trouble_of(*desk_),
          .parts = desk_->parts,
          .damage = desk_->damage};
}

Result<Record> BackgroundStore::read_back() {
  return failure(FaultKind::storage, status().path, "is with its worker, and cannot be read back");
}

}  // namespace

std::unique_ptr<Store> make_background_store(RecordWriter writer, RunInfo info, RunStatus status,
                                             const StoreOptions& options) {
  auto store = std::make_unique<BackgroundStore>(std::move(writer), std::move(info), status, options);
  store->start_workers();
  return store;
}

AttendedStore make_attended_store(RecordWriter writer, RunInfo info, RunStatus status, const StoreOptions& options) {
  auto store = std::make_unique<BackgroundStore>(std::move(writer), std::move(info), status, options);
  const auto attend = [desk = store.get()] { desk->attend(); };
  return {std::move(store), attend};
}

}  // namespace gyrotherm
