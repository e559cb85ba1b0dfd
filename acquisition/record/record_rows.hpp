/// The rows of a record as they come out of the file.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/run_info.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/result.hpp"
#include "core/sample.hpp"

namespace gyrotherm {

struct Record;

/// Everything that one open file holds. Fails with storage.
[[nodiscard]] Result<Record> record_of(Database& database);

/// One row of the table `sample`; NaN where NULL.
struct StoredRow {
  std::int64_t slot{};
  Duration monotonic{};
  std::optional<Duration> utc{};
  double chamber_air_c{};
  double chamber_set_point_c{};
  std::vector<double> thermometers_c;
  double gyro{};
  double interval_s{};
  ProfilePosition progress;  ///< its set point is NaN in an imported record
  RunState state{};          ///< older records have none
};

/// Opens a record to read it, and checks that it is one (check_schema). It may come from anywhere: nothing in it or
/// beside it changes, comes or goes, and no writer can begin while it is open. Fails with bad_file, also if a journal
/// lies beside it; with storage if it is being written or damaged.
[[nodiscard]] Result<Database> open_record(const std::string& path);

/// Calls `use` with each sample in order of slots; the row is overwritten by the next.
[[nodiscard]] Result<void> each_sample(Database& database, const RunInfo& info,
                                       const std::function<void(const StoredRow&)>& use);

/// Whether a run's clock, or the wall's, could show it, until 2116: differences of such times do not overflow.
[[nodiscard]] constexpr bool is_possible_time(Duration time) {
  return time >= Duration{} && time <= Duration(std::int64_t{1} << 62);
}

/// The last sample, if there is one.
[[nodiscard]] Result<std::optional<StoredRow>> last_row(Database& database, const RunInfo& info);

/// The last slot that has a sample or lies in a gap; −1 if none.
[[nodiscard]] Result<std::int64_t> last_slot(Database& database);

/// The reverse of name(…); an unknown name gives the first of them.
[[nodiscard]] Phase phase_named(std::string_view text);
[[nodiscard]] EventKind event_kind_named(std::string_view text);
[[nodiscard]] RunState run_state_named(std::string_view text);

}  // namespace gyrotherm
