/// A foreign text table, read by its map.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/record/import_map.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// Columns of equal length, one row per row of the file.
struct ForeignRows {
  std::vector<Duration> time;                       ///< since the first row, strictly increasing
  std::vector<Duration> interval;                   ///< what the gyro's number covers
  std::vector<std::vector<double>> thermometers_c;  ///< per thermometer of the map
  std::vector<double> gyro;                         ///< as in the file
};

/// Reads every row. Lines may end with LF or CRLF, a byte order mark is allowed, empty lines do not count; numbers have
/// a decimal point. A row's interval is the map's; where rows have times of their own it is their median spacing for a
/// rate, and for an increment the time since the row before (the first row: the median). Fails with bad_file at the
/// first mistake, as `file:line:column: what, what was expected`; also if there is no row, or where a line has more
/// than kLongestLine bytes or kMostFields fields (csv_line.hpp).
[[nodiscard]] Result<ForeignRows> parse_foreign_rows(std::string_view text, const ImportMap& map,
                                                     const std::string& file);

/// Spacings longer than 10 times the median one: the record misses rows there.
struct Silences {
  Duration median;  ///< spacing
  std::size_t count{};
  Duration total{};           ///< the sum of these spacings
  std::size_t first_after{};  ///< the row, from 0, after which the first of them comes
  Duration first{};
};
[[nodiscard]] Silences find_silences(const std::vector<Duration>& time);

}  // namespace gyrotherm
