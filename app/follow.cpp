// SPDX-License-Identifier: Apache-2.0
#include "app/follow.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>
#include <thread>

#include "acquisition/record/csv.hpp"
#include "acquisition/record/live_copy.hpp"
#include "acquisition/record/record.hpp"
#include "acquisition/record/status.hpp"
#include "app/interrupt.hpp"

namespace gyrotherm::app {
namespace {

using std::chrono::steady_clock;

constexpr auto kFollowEvery = std::chrono::milliseconds(200);
constexpr auto kSilence = std::chrono::seconds(2);  ///< of a copy that nobody writes: whoever did may have died
constexpr auto kCopyPatience =
    std::chrono::seconds(10);  ///< with a run that has no copy: it has only begun, or it ends

/// What has been printed so far, and what is printed next.
class Table {
 public:
  explicit Table(Console& console) : console_(console) {}
  void add(const record::Record& record) {
    const auto print = [this](std::string_view text) { console_.data(text); };
    if (!has_head_) record::write_csv_head(record.info, record.finished, print);
    has_head_ = true;
    record::write_csv_rows(record, last_, print);
    if (!record.slot.empty()) last_ = std::max(last_, record.slot.back());
  }
  [[nodiscard]] std::int64_t last() const { return last_; }

 private:
  Console& console_;
  bool has_head_{};
  std::int64_t last_ = -1;
};

bool is_being_written(const std::string& path) {
  const auto status = record::read_status(path);
  return status && status->being_written;
}

}  // namespace

Result<void> follow_record(Console& console, const std::string& path) {
  watch_for_interrupts(SecondInterrupt::ends);
  Table table(console);
  for (auto seen = steady_clock::now(); !interrupted() && !console.data_was_lost();
       std::this_thread::sleep_for(kFollowEvery)) {
    const auto rows = record::open_live_copy(path).and_then(
        [&](record::Database copy) { return record::record_of(copy, {.after = table.last()}); });
    if (rows) {
      const auto before = table.last();
      table.add(*rows);
      const auto now = steady_clock::now();
      if (table.last() > before || (now - seen >= kSilence && is_being_written(path))) seen = now;
      if (now - seen < kSilence) continue;
    }
    const auto whole = record::read_record(path);
    if (whole) return table.add(*whole), Result<void>();
    const bool may_come = rows || is_being_written(path);  // a copy stands there until its record is closed
    if (!may_come || steady_clock::now() - seen > kCopyPatience) return failure(whole.error());
  }
  return {};
}

}  // namespace gyrotherm::app
