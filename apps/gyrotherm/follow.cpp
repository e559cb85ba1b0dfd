// SPDX-License-Identifier: Apache-2.0
#include "apps/gyrotherm/follow.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>
#include <thread>

#include "acquisition/record/csv.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/record_files.hpp"
#include "acquisition/record/status.hpp"
#include "apps/console/interrupt.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono::steady_clock;

constexpr auto kFollowInterval = std::chrono::milliseconds(200);
/// Time without a new row after which the writer of a live copy may have died.
constexpr auto kSilenceBeforeCheck = std::chrono::seconds(2);
/// Longest wait for a live copy: the run has just started, or is about to end.
constexpr auto kLongestCopyWait = std::chrono::seconds(10);

/// Prints rows and keeps the last printed slot.
class Table {
 public:
  explicit Table(Console& console) : console_(console) {}
  void add(const record::Record& record) {
    const auto print = [this](std::string_view text) { console_.print(text); };
    if (!has_head_) record::write_csv_head(record.info, record.finished, print);
    has_head_ = true;
    run_ = record.info.id;
    record::write_csv_rows(record, last_, print);
    if (!record.slot.empty()) last_ = std::max(last_, record.slot.back());
  }
  [[nodiscard]] std::int64_t last() const { return last_; }
  /// Returns the id of the printed run, or an empty string before the first row.
  [[nodiscard]] const std::string& run() const { return run_; }

 private:
  Console& console_;
  bool has_head_{};
  std::string run_;
  std::int64_t last_ = -1;
};

bool is_being_written(const std::string& path) {
  const auto status = record::read_status(path);
  return status && status->being_written;
}

/// Returns the rows that are not printed yet. Refuses the live copy of another run: it may be left from a program that
/// died, or belong to a record with the same name without ".db".
Result<record::Record> new_rows(const std::string& path, const Table& table) {
  auto copy = record::open_live_copy(path);
  if (!copy) return failure(copy.error());
  const auto info = record::read_run_info(*copy);
  if (!info) return failure(info.error());
  auto run = table.run();
  if (run.empty())
    if (const auto status = record::read_status(path); status) run = status->id;
  if (!run.empty() && run != info->id) return failure(FaultKind::bad_file, copy->path(), "is a copy of another run");
  return record::read_open_record(*copy, {.after = table.last()});
}

/// Fails if another run uses the record's name by now.
Result<void> check_same_run(const std::string& path, const std::string& run, const Table& table) {
  if (table.run().empty() || run == table.run()) return {};
  return failure(FaultKind::bad_file, path,
                 "is now the record of another run; the printed rows belong to the previous run");
}

}  // namespace

Result<void> follow_record(Console& console, const std::string& given) {
  watch_for_interrupts(SecondInterrupt::ends);
  const auto path = record::record_of_copy(given);
  Table table(console);
  for (auto last_change = steady_clock::now(); !interrupted() && !console.has_lost_data();
       std::this_thread::sleep_for(kFollowInterval)) {
    const auto rows = new_rows(path, table);
    if (rows) {
      const auto before = table.last();
      table.add(*rows);
      const auto now = steady_clock::now();
      if (table.last() > before || (now - last_change >= kSilenceBeforeCheck && is_being_written(path)))
        last_change = now;
      if (now - last_change < kSilenceBeforeCheck) continue;
    }
    if (const auto status = record::read_status(path); status)
      if (auto same = check_same_run(path, status->id, table); !same) return same;
    const auto whole = record::read_record(path);
    if (whole) return check_same_run(path, whole->info.id, table).map([&] { table.add(*whole); });
    const bool may_appear = rows || is_being_written(path);  // copy exists until the record closes
    if (!may_appear || steady_clock::now() - last_change > kLongestCopyWait) return failure(whole.error());
  }
  return {};
}

}  // namespace gyrotherm::app
