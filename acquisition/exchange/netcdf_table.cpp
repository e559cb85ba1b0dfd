// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/netcdf_table.hpp"

#include <fmt/format.h>
#include <netcdf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "acquisition/exchange/civil_time.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/file.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

using record::into, record::kMissing;

/// What stands for a time in the file: its unit, and since when, if it says so.
struct TimeUnits {
  double unit_s{};
  std::optional<Duration> since{};
};

std::optional<double> seconds_of_unit(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, double>, 7> kWords{{{"microsecond", 1e-6},
                                                                       {"millisecond", 1e-3},
                                                                       {"nanosecond", 1e-9},
                                                                       {"second", 1},
                                                                       {"minute", 60},
                                                                       {"hour", 3600},
                                                                       {"day", 86400}}};
  constexpr std::array<std::pair<std::string_view, double>, 8> kShort{
      {{"s", 1}, {"sec", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}, {"min", 60}, {"h", 3600}, {"d", 86400}}};
  for (const auto& [name, seconds] : kWords)
    if (word == name || (word.starts_with(name) && word.substr(name.size()) == "s")) return seconds;
  for (const auto& [name, seconds] : kShort)
    if (word == name) return seconds;
  return std::nullopt;
}

/// "seconds since 2026-01-01 00:00:00 UTC", "ms".
std::optional<TimeUnits> parse_time_units(std::string_view text) {
  constexpr std::string_view kSince = " since ";
  const std::size_t since = text.find(kSince);
  const auto unit = seconds_of_unit(trimmed(text.substr(0, since)));
  if (!unit) return std::nullopt;
  if (since == std::string_view::npos) return TimeUnits{*unit};
  std::string instant(trimmed(text.substr(since + kSince.size())));
  if (instant.ends_with("UTC")) instant.replace(instant.size() - 3, 3, "Z");
  const auto time = parse_civil_time(instant);
  if (!time) return std::nullopt;
  return TimeUnits{*unit, time->reading - time->zone.value_or(Duration{})};
}

/// A variable, and what makes values of its numbers.
struct Variable {
  int id{};
  double scale = 1, offset = 0;
  std::optional<double> fill{}, missing{};

  [[nodiscard]] double value(double number) const {
    const bool is_there = std::isfinite(number) && number != fill && number != missing;
    return is_there ? number * scale + offset : kMissing;
  }
};

class NetcdfTable {
 public:
  explicit NetcdfTable(std::string path) : path_(std::move(path)) {}
  ~NetcdfTable() {
    if (file_ >= 0) nc_close(file_);
  }
  NetcdfTable(const NetcdfTable&) = delete;
  NetcdfTable& operator=(const NetcdfTable&) = delete;

  Result<void> open(const ImportMap& map) {
    if (auto opened = check(nc_open(path_.c_str(), NC_NOWRITE, &file_)); !opened) return opened;
    const auto time = find(map.time->name);
    if (!time) return wrong(describe_missing_columns({map.time->name}, names_along({})));
    std::array<int, NC_MAX_VAR_DIMS> dimensions{};
    if (nc_inq_vardimid(file_, time->id, dimensions.data()) == NC_NOERR) dimension_ = dimensions.front();
    if (auto size = check(nc_inq_dimlen(file_, *dimension_, &rows_)); !size) return size;
    time_ = *time;
    if (auto units = read_units(map.time->name); !units) return units;
    return find_columns(map);
  }

  Result<void> read(const TakeRow& take) {
    constexpr std::size_t kRowsAtOnce = 1 << 14;
    std::vector<double> numbers(columns_.size());
    for (std::size_t first = 0; first < rows_; first += kRowsAtOnce) {
      const std::size_t count = std::min(kRowsAtOnce, rows_ - first);
      if (auto read = read_part(first, count); !read) return read;
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t column = 0; column < columns_.size(); ++column) numbers[column] = part_[column + 1][i];
        if (auto taken = take_row(first + i, part_[0][i], numbers, take); !taken) return taken;
      }
    }
    return rows_ > 0 ? Result<void>{} : wrong("the file has no row, expected at least one");
  }

 private:
  tl::unexpected<Fault> wrong(std::string what) const {
    return failure(FaultKind::bad_file, path_, plain(std::move(what), Blanks::kept));
  }
  Result<void> check(int error) const {
    return error == NC_NOERR ? Result<void>{} : wrong(std::string("cannot be read as NetCDF: ") + nc_strerror(error));
  }

  /// A variable of numbers along one dimension; along that of time, once it is known.
  std::optional<Variable> along(int id) const {
    int dimensions = 0, dimension = -1;
    nc_type type{};
    if (nc_inq_var(file_, id, nullptr, &type, &dimensions, nullptr, nullptr) != NC_NOERR || dimensions != 1 ||
        nc_inq_vardimid(file_, id, &dimension) != NC_NOERR)
      return std::nullopt;
    const bool is_number = type != NC_CHAR && type != NC_STRING && type <= NC_MAX_ATOMIC_TYPE;
    if (!is_number || (dimension_ && dimension != *dimension_)) return std::nullopt;
    Variable variable{.id = id};
    variable.scale = number_attribute(id, "scale_factor").value_or(1);
    variable.offset = number_attribute(id, "add_offset").value_or(0);
    variable.fill = number_attribute(id, "_FillValue");
    variable.missing = number_attribute(id, "missing_value");
    return variable;
  }

  std::optional<Variable> find(const std::string& name) const {
    int id = -1;
    if (nc_inq_varid(file_, name.c_str(), &id) != NC_NOERR) return std::nullopt;
    return along(id);
  }

  std::vector<std::string> names_along(const std::vector<std::string>& but) const {
    std::vector<std::string> names;
    int count = 0;
    if (nc_inq_nvars(file_, &count) != NC_NOERR) return names;
    for (int id = 0; id < count; ++id) {
      std::array<char, NC_MAX_NAME + 1> name{};
      if (along(id) && nc_inq_varname(file_, id, name.data()) == NC_NOERR &&
          std::ranges::find(but, name.data()) == but.end())
        names.emplace_back(name.data());
    }
    return names;
  }

  std::optional<double> number_attribute(int variable, const char* name) const {
    std::size_t length = 0;
    nc_type type{};
    double number = 0;
    if (nc_inq_att(file_, variable, name, &type, &length) != NC_NOERR || length != 1 || type == NC_CHAR ||
        type >= NC_STRING || nc_get_att_double(file_, variable, name, &number) != NC_NOERR)
      return std::nullopt;
    return number;
  }

  std::string text_attribute(int variable, const char* name) const {
    constexpr std::size_t kLongest = 1000;
    std::size_t length = 0;
    nc_type type{};
    if (nc_inq_att(file_, variable, name, &type, &length) != NC_NOERR || type != NC_CHAR || length > kLongest)
      return "";
    std::string text(length, '\0');
    if (nc_get_att_text(file_, variable, name, text.data()) != NC_NOERR) return "";
    return text.substr(0, text.find('\0'));
  }

  Result<void> read_units(const std::string& name) {
    const auto units = text_attribute(time_.id, "units"), calendar = text_attribute(time_.id, "calendar");
    const auto parsed = parse_time_units(units);
    if (!parsed)
      return wrong(
          fmt::format("\"{}\" has the units \"{}\", expected like \"seconds since 2026-03-01 12:00:00\"", name, units));
    for (const char* usual : {"", "standard", "gregorian", "proleptic_gregorian", "none"})
      if (calendar == usual) units_ = *parsed;
    if (units_.unit_s > 0) return {};
    return wrong(fmt::format("\"{}\" counts by the calendar \"{}\", expected the usual one", name, calendar));
  }

  Result<void> find_columns(const ImportMap& map) {
    std::vector<std::string> missing;
    for (const ColumnName& column : map.columns())
      if (const auto found = find(column.name))
        columns_.push_back(*found);
      else
        missing.push_back(column.name);
    return missing.empty() ? Result<void>{} : wrong(describe_missing_columns(missing, names_along({map.time->name})));
  }

  Result<void> read_part(std::size_t first, std::size_t count) {
    part_.resize(columns_.size() + 1);
    for (std::size_t i = 0; i < part_.size(); ++i) {
      const Variable& variable = i == 0 ? time_ : columns_[i - 1];
      part_[i].resize(count);
      // Of numbers beyond a double the library says so, and puts what is nearest.
      const int error = nc_get_vara_double(file_, variable.id, &first, &count, part_[i].data());
      if (error != NC_ERANGE)
        if (auto read = check(error); !read) return read;
      for (double& number : part_[i]) number = variable.value(number);
    }
    return {};
  }

  Result<void> take_row(std::size_t row, double time, const std::vector<double>& numbers, const TakeRow& take) {
    const auto of_row = [&](std::string what) {
      return failure(FaultKind::bad_file, fmt::format("{}: row {}", path_, row), std::move(what));
    };
    if (!first_) first_ = time;
    const double since_first_s = (time - *first_) * units_.unit_s;
    if (!(std::abs(since_first_s) <= to_seconds(kLongestForeignTime)))
      return of_row("no time, or more than ten years after the first row");
    ForeignRow foreign{.time = from_seconds(since_first_s), .numbers = numbers};
    if (units_.since) {
      const double since_s = time * units_.unit_s;
      if (std::abs(since_s) > 20 * to_seconds(kLongestForeignTime)) return of_row("a time outside 1970 to 2116");
      foreign.utc = *units_.since + from_seconds(since_s);
      if (!record::is_possible_time(*foreign.utc)) return of_row("a time outside 1970 to 2116");
    }
    auto taken = take(foreign);
    return !taken && taken.error().where.empty() ? of_row(std::move(taken.error().what)) : taken;
  }

  std::string path_;
  int file_ = -1;
  std::optional<int> dimension_{};
  std::size_t rows_{};
  Variable time_{};
  TimeUnits units_{};
  std::vector<Variable> columns_{};
  std::vector<std::vector<double>> part_{};  ///< time, then the columns
  std::optional<double> first_{};
};

}  // namespace

bool is_netcdf(std::string_view beginning) {
  return beginning.starts_with("\x89HDF\r\n\x1A\n") || beginning.starts_with("CDF\x01") ||
         beginning.starts_with("CDF\x02") || beginning.starts_with("CDF\x05");
}

Result<void> read_netcdf(const std::string& path, const ImportMap& map, const TakeRow& take) {
  if (const auto regular = open_regular_file(path); !regular) return failure(regular.error());
  NetcdfTable table(path);
  return table.open(map).and_then([&] { return table.read(take); });
}

}  // namespace gyrotherm::exchange
