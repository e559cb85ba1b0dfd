// SPDX-License-Identifier: Apache-2.0
/// A record under observation: the real store does the work, and its input is kept for comparison.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "acquisition/record/record.hpp"
#include "acquisition/record/store.hpp"

namespace gyrotherm::faults {

/// Hash of all rows, events and gaps in order. The same seed always gives the same hash.
class LogHash {
 public:
  void add(std::string_view text);
  void add(std::int64_t number);
  void add(double number);
  void add(const Sample& sample);
  void add(const Event& event);
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;  // FNV-1a
};

class RecordingStore final : public record::Store {
 public:
  /// `hash` must outlive this object.
  RecordingStore(std::unique_ptr<record::Store> store, LogHash& hash) : store_(std::move(store)), hash_(hash) {}

  [[nodiscard]] Result<void> append(const Sample& sample, std::span<const Event> events) override;
  [[nodiscard]] Result<void> append_gap(std::int64_t first, std::int64_t last, const std::string& cause) override;
  [[nodiscard]] Result<void> append_event(const Event& event) override;
  [[nodiscard]] Result<void> append_decision(const Event& event,
                                             std::span<const record::RunInfo::SegmentInfo> segments) override;
  [[nodiscard]] Result<std::int64_t> sync() override {
    auto synced = store_->sync();
    if (synced) acknowledged_ = *synced;
    return synced;
  }
  [[nodiscard]] bool settle(Duration longest) override { return store_->settle(longest); }
  [[nodiscard]] Result<void> finish() override { return store_->finish(); }
  void publish(const RunOverview& overview) override { store_->publish(overview); }
  [[nodiscard]] record::StoreHealth health() const override { return store_->health(); }
  [[nodiscard]] const record::Alarms& alarms() const override { return store_->alarms(); }
  [[nodiscard]] const record::RunInfo& info() const override { return store_->info(); }
  [[nodiscard]] Result<record::Record> read_back() override { return store_->read_back(); }

  struct GapSeen {
    std::int64_t first{}, last{};
    std::string cause;
  };
  /// Returns the input since the last forget().
  [[nodiscard]] const std::optional<Sample>& sample() const { return sample_; }
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }
  [[nodiscard]] const std::vector<GapSeen>& gaps() const { return gaps_; }
  [[nodiscard]] std::int64_t acknowledged() const { return acknowledged_; }
  void forget() { sample_.reset(), events_.clear(), gaps_.clear(); }

 private:
  std::unique_ptr<record::Store> store_;
  LogHash& hash_;
  std::optional<Sample> sample_;
  std::vector<Event> events_;
  std::vector<GapSeen> gaps_;
  std::int64_t acknowledged_ = -1;
};

}  // namespace gyrotherm::faults
