// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/disk.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "acquisition/record/record_writer.hpp"
#include "acquisition/record/run_file.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"
#include "tests/sequencer/faults/fault_injector.hpp"

namespace gyrotherm::faults {
namespace {

using Kind = InjectedFaultKind;

const record::StoreOptions kOfManySyncs{.status_interval = std::chrono::seconds(1)};

}  // namespace

bool is_disk_fault(InjectedFaultKind kind) { return kind >= Kind::disk_full && kind <= Kind::disk_hangs; }

bool has_faults_of_disk(const Schedule& schedule) {
  return std::ranges::any_of(schedule, [](const auto& fault) {
    return is_disk_fault(fault.kind) || concerns_record(fault.kind) || fault.kind == Kind::power_cut;
  });
}

Disk::Disk(bool breaks, std::string path, std::int64_t most_rows) : path_(std::move(path)), most_rows_(most_rows) {
  if (breaks) vfs_.emplace();
}

/// Removes all files of the record.
Disk::~Disk() {
  const std::filesystem::path path(path_);
  if (path_ == record::kInMemory || path.parent_path().empty()) return;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(path.parent_path(), error))
    if (entry.path().filename().string().starts_with(path.stem().string() + "."))
      std::filesystem::remove(entry.path(), error);
}

Result<std::unique_ptr<record::Store>> Disk::open_store(record::RunFile file, record::RunStatus status,
                                                        record::Alarms alarms, int part, std::int64_t last_event) {
  auto info = file.info();
  record::RecordWriter writer(std::move(file), path_,
                              {.most_rows = static_cast<std::size_t>(most_rows_),
                               .part = part,
                               .last_slot = status.acknowledged,
                               .last_event = last_event});
  record::StoreOptions options;
  options.most_rows = most_rows_;
  auto made = make_attended_store(std::move(writer), std::move(info), std::move(status), std::move(alarms), options);
  attend_ = std::move(made.attend);
  return std::move(made.store);
}

Result<std::unique_ptr<record::Store>> Disk::create(const record::RunInfo& info) {
  if (!vfs_) return record::Store::create(path_, info, kOfManySyncs);
  auto file = record::RunFile::create(path_, info);
  if (!file) return failure(file.error());
  return open_store(std::move(*file), make_first_status(path_, info), {}, 1, 0);
}

Result<std::unique_ptr<record::Store>> Disk::reopen() {
  if (!vfs_) return record::Store::reopen(path_, kOfManySyncs);
  const auto files = record::find_record_files(path_);
  if (!files) return failure(files.error());
  const record::Part& last = files->parts.back();
  auto alarms = record::read_record_alarms(*files);
  if (!alarms) return failure(alarms.error());
  const auto last_event = record::read_last_event_number(*files);
  if (!last_event) return failure(last_event.error());
  auto file = record::RunFile::reopen(last.path);
  if (!file) return failure(file.error());
  auto status = record::read_stored_status(file->database(), path_);
  if (!status) return failure(status.error());
  return open_store(std::move(*file), std::move(*status), std::move(*alarms), last.continuation.part, *last_event);
}

void Disk::inject(const std::vector<InjectedFault>& active) {
  if (!vfs_) return;
  Schedule now;
  std::ranges::copy_if(active, std::back_inserter(now), [](const auto& fault) { return is_disk_fault(fault.kind); });
  if (now == active_) return;
  heal();
  active_ = std::move(now);
  for (const auto& fault : active_) {
    takes_nothing_ = takes_nothing_ || fault.kind != Kind::disk_slow;
    switch (fault.kind) {
      case Kind::disk_full: vfs_->fail(1, true, tests::FailingVfs::Kind::full); break;
      case Kind::disk_fails: vfs_->fail(1, true, tests::FailingVfs::Kind::io_error); break;
      case Kind::disk_loses_syncs: vfs_->fail(1, true, tests::FailingVfs::Kind::sync_error); break;
      case Kind::disk_slow: every_ = std::max(every_, static_cast<std::int64_t>(fault.size)); break;
      case Kind::disk_hangs: hangs_ = true; break;
      default: break;
    }
  }
}

void Disk::fail_once(std::int64_t operation) {
  if (!vfs_ || takes_nothing_) return;
  vfs_->fail(std::max<std::int64_t>(operation, 1), false, tests::FailingVfs::Kind::io_error);
  fails_once_ = true;
}

bool Disk::is_failing() const { return takes_nothing_ || (fails_once_ && vfs_->failures() == 0); }

bool Disk::attack(const InjectedFault& fault, int part) {
  namespace fs = std::filesystem;
  const auto file = record::part_path(path_, part) + (fault.target == 0 ? "" : "-wal");
  std::error_code error;
  const auto size = static_cast<double>(fs::file_size(file, error));
  if (error || (fault.kind == Kind::file_cut && size == 0)) return false;
  const auto place = static_cast<std::streamoff>(fault.size * size);
  switch (fault.kind) {
    case Kind::file_removed: fs::remove(file, error); break;
    case Kind::file_replaced:
      fs::copy_file(file, file + ".copy", error);
      fs::rename(file + ".copy", file, error);
      break;
    case Kind::file_cut: fs::resize_file(file, static_cast<std::uintmax_t>(place), error); break;
    case Kind::file_overwritten: {
      constexpr std::size_t kMuch = 4096;
      std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
      stream.seekp(place);
      stream << std::string(kMuch, 'x');
      break;
    }
    default: return false;
  }
  return true;
}

void Disk::heal() {
  if (vfs_) vfs_->heal();
  active_.clear();
  takes_nothing_ = hangs_ = fails_once_ = false;
  every_ = 1;
}

/// Lets the program die. Writes that it attempts meanwhile have no effect.
void Disk::leave(bool power_cut, unsigned seed, const std::function<void()>& die) {
  attend_ = nullptr;
  if (vfs_) vfs_->fail(1, true, tests::FailingVfs::Kind::power_cut);
  die();
  if (vfs_ && power_cut) vfs_->lose_unsynced_data(seed);
  heal();
}

void Disk::advance(std::int64_t second) {
  if (attend_ && !hangs_ && second % every_ == 0) attend_();
}

}  // namespace gyrotherm::faults
