// SPDX-License-Identifier: Apache-2.0
/// Calls the functions of the store that rigs may use. apps/site/migrations/0001-store.sql documents each function and
/// its checks. All calls fail like Postgres, and with refused if the function refuses the call.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "apps/site/check_histories.hpp"
#include "apps/site/postgres.hpp"
#include "apps/site/run_text.hpp"
#include "core/result.hpp"

namespace gyrotherm::site {

/// Number of the oldest migration that this program can use.
inline constexpr int kOldestStore = 1;
/// Number of the migration that added check standards.
inline constexpr int kCheckStandardStore = 4;
/// Number of the migration that added the segments of runs that end by themselves.
inline constexpr int kGrowingRunStore = 7;

class Store {
 public:
  explicit Store(Postgres connection, std::int64_t version = kOldestStore)
      : connection_(std::move(connection)), version_(version) {}

  /// Connects. Fails with refused if the user may not use the store, or if the store is older than this program.
  [[nodiscard]] static Result<Store> open(const StoreAddress& address, const WaitLimits& limits);

  /// Returns the last slot, event and gap of a run that the store has, or nothing if it does not have the run.
  [[nodiscard]] Result<std::optional<RunPosition>> position(const std::string& run);
  [[nodiscard]] Result<void> add_run(const std::string& run, const std::string& rig, const std::string& json);
  /// Returns whether the store has the migration that add_segments() needs.
  [[nodiscard]] bool has_growing_runs() const { return version_ >= kGrowingRunStore; }
  /// Sends all segments of a run. Those that the store has must be the first ones.
  [[nodiscard]] Result<void> add_segments(const std::string& run, const std::string& json);
  /// Sends rows without waiting for the result, so the caller can read the next batch before it calls await_rows().
  [[nodiscard]] Result<void> send_rows(const std::string& run, const RowBatch& batch);
  [[nodiscard]] Result<void> await_rows();
  [[nodiscard]] Result<void> add_events(const std::string& run, std::int64_t after, const std::string& json);
  [[nodiscard]] Result<void> add_gaps(const std::string& run, std::int64_t after, const std::string& json);
  [[nodiscard]] Result<void> update_state(const std::string& run, const LiveState& now);
  [[nodiscard]] Result<void> finish_run(const std::string& run, const std::string& json);
  [[nodiscard]] Result<bool> has_document(const std::string& sha256);
  [[nodiscard]] Result<void> add_document(const std::string& rig, const Document& document);

  /// Returns whether the store has the migration that add_check_standard() needs.
  [[nodiscard]] bool has_check_standards() const { return version_ >= kCheckStandardStore; }
  [[nodiscard]] Result<void> add_check_standard(const std::string& rig, const CheckCharts& charts);

  [[nodiscard]] std::string describe() const { return connection_.describe(); }

 private:
  [[nodiscard]] Result<void> call(const std::string& statement, const std::vector<Parameter>& parameters);

  Postgres connection_;
  std::int64_t version_;
};

}  // namespace gyrotherm::site
