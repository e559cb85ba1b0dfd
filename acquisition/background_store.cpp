#include "acquisition/background_store.hpp"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/backlog.hpp"
#include "acquisition/ordered_store.hpp"
#include "acquisition/record.hpp"
#include "drivers/line/block_signals.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kMostAtOnce = 1000;  ///< rows of one transaction
constexpr auto kLongestFinish = std::chrono::seconds(30);
constexpr auto kLongestFarewell = std::chrono::seconds(10);

/// What the store and its worker share. Only the worker touches the writer and the disk, until it has ended.
struct Desk {
  Desk(RecordWriter record_writer, RunStatus run_status, const StoreOptions& options)
      : retry(options.retry),
        backlog(static_cast<std::size_t>(options.most_rows)),
        status(std::move(run_status)),
        acknowledged(status.acknowledged),
        writer(std::move(record_writer)) {}

  const Duration retry;
  std::mutex mutex;  ///< of everything down to the writer
  std::condition_variable work;
  std::condition_variable progress;
  Backlog backlog;
  std::size_t dropped_before{};  ///< rows, when the disk last took something
  RunStatus status;              ///< as of the last sync
  FrameCount frames;             ///< likewise
  bool wanted{};                 ///< a sync was asked for
  bool busy{};                   ///< … and is being carried out
  bool stop{};
  bool ended{};
  std::int64_t acknowledged;
  std::string trouble;
  int parts{1};
  RecordWriter writer;
};

Result<void> write(RecordWriter& writer, std::span<const EntryPointer> entries, const FrameCount& frames) {
  if (entries.empty()) return {};
  auto written = writer.write(entries, frames);
  if (written || RecordWriter::will_pass(written.error())) return written;
  return writer.write(entries, frames);  // into a new part
}

/// The status as the disk has it.
RunStatus told_of(const Desk& desk, std::int64_t last_appended) {
  RunStatus status = desk.status;
  status.acknowledged = desk.acknowledged;
  status.backlog_s = last_appended - desk.acknowledged;
  status.storage_trouble = desk.trouble;
  for (int part = 2; part <= desk.parts; ++part) status.parts.push_back(part_path(status.path, part));
  return status;
}

/// One transaction, and the status file; called and returns with the lock.
void write_once(Desk& desk, std::unique_lock<std::mutex>& lock) {
  desk.wanted = false;
  desk.busy = true;
  const auto batch = desk.backlog.take(kMostAtOnce);
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
  desk.wanted = desk.wanted || (written && batch.size() == kMostAtOnce);
  const auto status = told_of(desk, std::max(desk.status.slot, desk.acknowledged));
  lock.unlock();
  [[maybe_unused]] const auto told = write_status(status);  // a courtesy
  lock.lock();
  desk.busy = false;
  desk.progress.notify_all();
}

void serve(Desk& desk) {
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
  desk.ended = true;
  desk.progress.notify_all();
}

class BackgroundStore final : public OrderedStore {
 public:
  BackgroundStore(RecordWriter writer, RunInfo info, const RunStatus& status, const StoreOptions& options)
      : OrderedStore(std::move(info), status),
        desk_(std::make_shared<Desk>(std::move(writer), status, options)),
        worker_([desk = desk_] { serve(*desk); }) {}
  ~BackgroundStore() override { stop(); }
  BackgroundStore(const BackgroundStore&) = delete;
  BackgroundStore& operator=(const BackgroundStore&) = delete;

  Result<std::int64_t> sync() override;
  bool settle(Duration longest) override;
  Result<void> finish() override;
  StoreHealth health() const override;
  Result<Record> read_back() override;

 private:
  Result<void> take(Entry entry) override;
  bool stop();

  std::shared_ptr<Desk> desk_;
  std::thread worker_;
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
  return desk_->acknowledged;
}

bool BackgroundStore::settle(Duration longest) {
  if (!sync()) return true;
  std::unique_lock lock(desk_->mutex);
  return desk_->progress.wait_for(lock, longest,
                                  [this] { return desk_->backlog.empty() && !desk_->wanted && !desk_->busy; });
}

/// Ends the worker; false if it hangs in the disk, and is left behind there.
bool BackgroundStore::stop() {
  if (!worker_.joinable()) return true;
  {
    std::unique_lock lock(desk_->mutex);
    desk_->stop = true;
    desk_->work.notify_one();
    if (!desk_->progress.wait_for(lock, kLongestFarewell, [this] { return desk_->ended; })) {
      worker_.detach();
      return false;
    }
  }
  worker_.join();
  return true;
}

Result<void> BackgroundStore::finish() {
  if (!settle(kLongestFinish)) {
    const auto now = health();
    return failure(FaultKind::storage, status().path,
                   fmt::format("{} s are not on the disk: {}", now.backlog_s, now.trouble));
  }
  if (finished_) return failure(FaultKind::storage, status().path, "the run is finished");
  if (!stop()) return failure(FaultKind::storage, status().path, "a write does not come back from the disk");
  finished_ = true;
  if (auto done = desk_->writer.finish(); !done) return done;
  auto told = told_of(*desk_, last());
  told.finished = true;
  told.being_written = false;
  [[maybe_unused]] const auto written = write_status(told);
  return {};
}

StoreHealth BackgroundStore::health() const {
  const std::lock_guard lock(desk_->mutex);
  return {.backlog_s = last() - desk_->acknowledged,
          .rows_dropped = desk_->backlog.dropped() > desk_->dropped_before,
          .trouble = desk_->trouble,
          .parts = desk_->parts};
}

Result<Record> BackgroundStore::read_back() {
  return failure(FaultKind::storage, status().path, "is with its worker, and cannot be read back");
}

}  // namespace

std::unique_ptr<Store> make_background_store(RecordWriter writer, RunInfo info, RunStatus status,
                                             const StoreOptions& options) {
  return std::make_unique<BackgroundStore>(std::move(writer), std::move(info), status, options);
}

}  // namespace gyrotherm
