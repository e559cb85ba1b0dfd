#include "acquisition/record/store.hpp"

#include <unistd.h>

#include <optional>
#include <utility>

#include "acquisition/record/background_store.hpp"
#include "acquisition/record/chain_check.hpp"
#include "acquisition/record/ordered_store.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_rows.hpp"
#include "acquisition/record/record_status.hpp"
#include "acquisition/record/run_file.hpp"

namespace gyrotherm {
namespace {

/// Writes inside its calls.
class InlineStore final : public OrderedStore {
 public:
  InlineStore(RunFile file, const RunStatus& status, int part)
      : OrderedStore(file.info(), status), acknowledged_(status.acknowledged), part_(part), file_(std::move(file)) {}

  Result<std::int64_t> sync() override;
  bool settle(Duration /*longest*/) override { return sync().has_value(); }
  Result<void> finish() override;
  /// What nobody has asked to make durable does not wait for the disk.
  StoreHealth health() const override {
    return {.backlog_s = broken_ ? last() - acknowledged_ : 0, .trouble = broken_ ? text(*broken_) : ""};
  }
  Result<Record> read_back() override {
    return file_ ? record_of(file_->database()) : Result<Record>(failure(*broken_));
  }

 private:
  Result<void> take(Entry entry) override;
  Result<void> open_batch();
  Result<void> keep(Result<void> result);
  void tell(bool finished) const;

  std::int64_t acknowledged_{-1};
  bool batch_open_{};
  std::optional<Fault> broken_;  ///< the first failure of the file: after it nothing is acknowledged any more
  int part_{};
  std::optional<RunFile> file_;  ///< gone after finish(), but in memory
};

/// Remembers a failure of the file, which is not touched again.
Result<void> InlineStore::keep(Result<void> result) {
  if (!result && !broken_) {
    broken_ = result.error();
    file_->leave_untouched();
  }
  return result;
}

/// The status file is a courtesy: a run does not end because it could not be written.
void InlineStore::tell(bool finished) const {
  if (status().path == kInMemory) return;
  RunStatus now = status();
  now.acknowledged = acknowledged_;
  now.finished = finished;
  now.being_written = !finished;
  [[maybe_unused]] const auto told = write_status(now);
}

Result<void> InlineStore::open_batch() {
  if (broken_) return failure(*broken_);
  if (batch_open_) return {};
  batch_open_ = true;
  return file_->begin();
}

Result<void> InlineStore::take(Entry entry) {
  return keep(open_batch().and_then([&] { return file_->insert(entry); }));
}

Result<std::int64_t> InlineStore::sync() {
  if (broken_) return failure(*broken_);
  if (std::exchange(batch_open_, false)) {
    const auto done = keep(file_->replace_frames(frames()).and_then([&] { return file_->commit(); }));
    if (!done) return failure(done.error());
    acknowledged_ = last();
    if (const auto folded = keep(file_->fold_log()); !folded) return failure(folded.error());
  }
  tell(false);
  return acknowledged_;
}

Result<void> InlineStore::finish() {
  if (auto synced = sync(); !synced) return failure(synced.error());
  if (auto done = keep(file_->finish()); !done) return done;
  broken_ = Fault{FaultKind::storage, status().path, "the run is finished"};
  if (status().path == kInMemory) return {};
  file_.reset();
  if (auto written = close_record(status().path, part_); !written) return written;
  tell(true);
  return {};
}

Result<std::unique_ptr<Store>> opened(RunFile file, RunStatus status, const StoreOptions& options, int part) {
  status.pid = ::getpid();
  status.being_written = true;
  if (status.path == kInMemory) return std::make_unique<InlineStore>(std::move(file), status, part);
  if (auto told = write_status(status); !told && !options.background) return failure(told.error());
  if (!options.background) return std::make_unique<InlineStore>(std::move(file), status, part);
  RunInfo info = file.info();
  RecordWriter writer(
      std::move(file), status.path,
      {.most_rows = static_cast<std::size_t>(options.most_rows), .part = part, .last_slot = status.acknowledged});
  return make_background_store(std::move(writer), std::move(info), std::move(status), options);
}

}  // namespace

Result<std::unique_ptr<Store>> Store::create(const std::string& path, const RunInfo& info,
                                             const StoreOptions& options) {
  auto file = RunFile::create(path, info);
  if (!file) return failure(file.error());
  if (auto proved = file->prove(); !proved) {
    file = failure(proved.error());
    remove_record(path);
    return failure(proved.error());
  }
  return opened(std::move(*file), first_status(path, info), options, 1);
}

Result<std::unique_ptr<Store>> Store::reopen(const std::string& path, const StoreOptions& options) {
  const auto part = last_part(path);
  if (!part) return failure(part.error());
  auto file = RunFile::reopen(part_path(path, *part));
  if (!file) return failure(file.error());
  auto status = stored_status(file->database(), path);
  if (!status) return failure(status.error());
  if (auto proved = file->prove(); !proved) return failure(proved.error());
  return opened(std::move(*file), std::move(*status), options, *part);
}

void remove_record(const std::string& path) {
  for (const char* suffix : {"", "-wal", "-journal", "-shm"}) ::unlink((path + suffix).c_str());
  ::unlink(status_path(path).c_str());
}

}  // namespace gyrotherm
