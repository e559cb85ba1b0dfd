/// The law of slots, and what the status file tells: the same for every store. Each slot has exactly one row or lies in
/// exactly one gap.
#pragma once

#include <cstdint>
#include <string>

#include "acquisition/record/entry.hpp"
#include "acquisition/record/status.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm {

class OrderedStore : public Store {
 public:
  Result<void> append(const Sample& sample, std::span<const Event> events) final;
  Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) final;
  Result<void> append_event(const Event& event) final;
  void publish(const Outlook& outlook) final;
  const RunInfo& info() const final { return info_; }

 protected:
  OrderedStore(RunInfo info, RunStatus status);

  /// Entries come in order, each where the one before ended.
  virtual Result<void> take(Entry entry) = 0;

  [[nodiscard]] const RunStatus& status() const { return status_; }
  [[nodiscard]] FrameCount frames() const { return status_.frames.value_or(before_); }
  [[nodiscard]] std::int64_t last() const { return last_; }

 private:
  Result<void> follow_on(std::int64_t slot) const;
  void show(const Sample& sample);

  RunInfo info_;
  RunStatus status_;     ///< of what was appended
  FrameCount before_;    ///< frames before this program took the run up
  std::int64_t last_{};  ///< appended
};

}  // namespace gyrotherm
