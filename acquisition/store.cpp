#include "acquisition/store.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cassert>
#include <optional>
#include <utility>

#include "acquisition/record_status.hpp"
#include "acquisition/run_file.hpp"

namespace gyrotherm {
namespace {

template <class T>
std::optional<T> value_of(const Reading<T>& reading) {
  return reading.value ? std::optional<T>(*reading.value) : std::nullopt;
}

/// Holds the law of slots – each has exactly one row or lies in exactly one gap – and the line between what was
/// appended and what is acknowledged.
class SqliteStore final : public Store {
 public:
  SqliteStore(RunFile file, RunStatus status) : file_(std::move(file)), status_(std::move(status)) {
    last_ = status_.acknowledged;
    before_ = status_.frames.value_or(FrameCount{});
    readings_c_.resize(file_.info().thermometers.size());
  }

  Result<void> append(const Sample& sample, std::span<const Event> events) override;
  Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) override;
  Result<void> append_event(const Event& event) override;
  Result<std::int64_t> sync() override;
  Result<void> finish() override;
  const RunInfo& info() const override { return file_.info(); }

 private:
  void tell() const;
  Result<void> follow_on(std::int64_t slot) const;
  Result<void> open_batch();
  Result<void> insert(const Sample& sample, std::span<const Event> events);
  Result<void> insert_row(const Sample& sample);
  Result<void> insert_faults(const Sample& sample);
  template <class T>
  Result<void> insert_fault(std::int64_t slot, std::string_view channel, const Reading<T>& reading);
  Result<void> keep(Result<void> result);
  void show(const Sample& sample);

  RunFile file_;
  RunStatus status_;
  std::vector<double> readings_c_;
  FrameCount before_;      ///< frames before this program took the run up
  std::int64_t last_{-1};  ///< appended; status_.acknowledged is synced
  bool batch_open_{};
  std::optional<Fault> broken_;  ///< the first failure of the file: after it nothing is acknowledged any more
};

/// Remembers a failure of the file.
Result<void> SqliteStore::keep(Result<void> result) {
  if (!result && !broken_) broken_ = result.error();
  return result;
}

/// The status file is a courtesy: a run does not end because it could not be written.
void SqliteStore::tell() const { [[maybe_unused]] const auto told = write_status(status_); }

Result<void> SqliteStore::follow_on(std::int64_t slot) const {
  if (slot == last_ + 1) return {};
  const std::string where = fmt::format("slot {}", slot);
  if (slot <= last_) return failure(FaultKind::storage, where, fmt::format("comes after slot {}", last_));
  return failure(FaultKind::storage, where,
                 fmt::format("slots {} to {} have neither a sample nor a gap", last_ + 1, slot - 1));
}

Result<void> SqliteStore::open_batch() {
  if (broken_) return failure(*broken_);
  if (batch_open_) return {};
  batch_open_ = true;
  return file_.begin();
}

template <class T>
Result<void> SqliteStore::insert_fault(std::int64_t slot, std::string_view channel, const Reading<T>& reading) {
  if (reading.value) return {};
  ++status_.faults;
  return file_.insert_fault(slot, channel, reading.value.error());
}

Result<void> SqliteStore::insert_faults(const Sample& sample) {
  auto done = insert_fault(sample.slot, "chamber", sample.chamber);
  for (std::size_t i = 0; done && i < sample.thermometers.size(); ++i)
    done = insert_fault(sample.slot, info().thermometers[i].name, sample.thermometers[i]);
  return done ? insert_fault(sample.slot, "gyro", sample.gyro) : done;
}

Result<void> SqliteStore::insert_row(const Sample& sample) {
  SampleRow row{.slot = sample.slot, .monotonic = sample.at.since_start, .utc = sample.at.utc};
  if (const auto& chamber = sample.chamber.value) {
    row.chamber_air_c = chamber->air.value;
    row.chamber_set_point_c = chamber->set_point.value;
  }
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    readings_c_[i] = sample.thermometers[i].value.value_or(Celsius{kMissing}).value;
  row.thermometers_c = readings_c_;
  if (const auto& gyro = sample.gyro.value) {
    row.gyro = static_cast<double>(gyro->pulses);
    row.interval = gyro->interval;
  }
  row.progress = sample.progress;
  return file_.insert(row);
}

Result<void> SqliteStore::insert(const Sample& sample, std::span<const Event> events) {
  auto done = open_batch().and_then([&] { return insert_row(sample); }).and_then([&] { return insert_faults(sample); });
  for (const Event& event : events)
    if (done) done = file_.insert_event(sample.slot, event);
  return done;
}

void SqliteStore::show(const Sample& sample) {
  status_.slot = sample.slot;
  const auto& frames = sample.gyro_frames;
  status_.frames = {before_.seen + frames.seen, before_.lost + frames.lost, before_.bad + frames.bad};
  show_progress(status_, info(), sample.progress);
  const auto chamber = value_of(sample.chamber);
  status_.chamber_air = chamber ? std::optional(chamber->air) : std::nullopt;
  for (std::size_t i = 0; i < sample.thermometers.size(); ++i)
    status_.thermometers[i].reading = value_of(sample.thermometers[i]);
}

Result<void> SqliteStore::append(const Sample& sample, std::span<const Event> events) {
  assert(sample.thermometers.size() == info().thermometers.size());
  if (auto follows = follow_on(sample.slot); !follows) return follows;
  if (auto done = keep(insert(sample, events)); !done) return done;
  last_ = sample.slot;
  show(sample);
  return {};
}

Result<void> SqliteStore::append_gap(std::int64_t first, std::int64_t last, const std::string& cause) {
  assert(first <= last);
  if (auto follows = follow_on(first); !follows) return follows;
  auto done = keep(open_batch().and_then([&] { return file_.insert_gap(first, last, cause); }));
  if (done) last_ = last;
  return done;
}

Result<void> SqliteStore::append_event(const Event& event) {
  return keep(open_batch().and_then([&] { return file_.insert_event(last_, event); }));
}

Result<std::int64_t> SqliteStore::sync() {
  if (broken_) return failure(*broken_);
  if (std::exchange(batch_open_, false)) {
    const auto done =
        keep(file_.replace_frames(status_.frames.value_or(before_)).and_then([&] { return file_.commit(); }));
    if (!done) return failure(done.error());
  }
  status_.acknowledged = last_;
  tell();
  return last_;
}

Result<void> SqliteStore::finish() {
  if (auto synced = sync(); !synced) return failure(synced.error());
  if (auto done = keep(file_.finish()); !done) return done;
  broken_ = Fault{FaultKind::storage, status_.path, "the run is finished"};
  status_.finished = true;
  status_.being_written = false;
  tell();
  return {};
}

Result<std::unique_ptr<Store>> opened(RunFile file, RunStatus status) {
  status.pid = ::getpid();
  status.being_written = true;
  if (auto told = write_status(status); !told) return failure(told.error());
  return std::make_unique<SqliteStore>(std::move(file), std::move(status));
}

}  // namespace

Result<std::unique_ptr<Store>> Store::create(const std::string& path, const RunInfo& info) {
  auto file = RunFile::create(path, info);
  if (!file) return failure(file.error());
  return opened(std::move(*file), first_status(path, info));
}

Result<std::unique_ptr<Store>> Store::reopen(const std::string& path) {
  auto file = RunFile::reopen(path);
  if (!file) return failure(file.error());
  auto status = stored_status(file->database(), path);
  if (!status) return failure(status.error());
  return opened(std::move(*file), std::move(*status));
}

}  // namespace gyrotherm
