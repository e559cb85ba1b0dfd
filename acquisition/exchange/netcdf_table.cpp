// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/netcdf_table.hpp"

#include <fmt/format.h>
#include <netcdf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/exchange/bytes.hpp"
#include "acquisition/exchange/column_names.hpp"
#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/record/row.hpp"
#include "acquisition/record/sqlite.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

using record::kMissing;

/// The unit of a counted time and its reference instant since 1970, if it has one.
struct TimeUnits {
  Duration unit{};
  std::optional<CountedTime> since{};
};

std::optional<Duration> find_time_unit(std::string_view word) {
  using std::chrono::microseconds, std::chrono::milliseconds, std::chrono::minutes, std::chrono::hours;
  constexpr std::array<std::pair<std::string_view, Duration>, 16> kWords{{{"nanosecond", Duration(1)},
                                                                          {"nanosec", Duration(1)},
                                                                          {"nsec", Duration(1)},
                                                                          {"usec", microseconds(1)},
                                                                          {"microsecond", microseconds(1)},
                                                                          {"microsec", microseconds(1)},
                                                                          {"millisecond", milliseconds(1)},
                                                                          {"millisec", milliseconds(1)},
                                                                          {"msec", milliseconds(1)},
                                                                          {"second", kSecond},
                                                                          {"sec", kSecond},
                                                                          {"minute", minutes(1)},
                                                                          {"min", minutes(1)},
                                                                          {"hour", hours(1)},
                                                                          {"hr", hours(1)},
                                                                          {"day", hours(24)}}};
  constexpr std::array<std::pair<std::string_view, Duration>, 6> kLetters{{{"s", kSecond},
                                                                           {"ms", milliseconds(1)},
                                                                           {"us", microseconds(1)},
                                                                           {"ns", Duration(1)},
                                                                           {"h", hours(1)},
                                                                           {"d", hours(24)}}};
  for (const auto& [name, unit] : kLetters)
    if (word == name) return unit;
  if (word.ends_with('s')) word.remove_suffix(1);
  for (const auto& [name, unit] : kWords)
    if (word == name) return unit;
  return std::nullopt;
}

/// Parses a time unit with or without a reference instant, such as "seconds since 2026-01-01 00:00:00 UTC" or "ms".
/// Returns an error message if the text is not one.
tl::expected<TimeUnits, std::string> parse_time_units(const std::string& stated, EarlyDays early) {
  constexpr std::string_view kSince = " since ";
  const std::string text = in_lower_case(stated);
  const std::size_t since = text.find(kSince);
  const std::string word(trimmed(std::string_view(text).substr(0, since)));
  const auto unit = find_time_unit(word);
  if (!unit)
    return tl::unexpected(
        fmt::format("\"{}\" is not a unit of time, expected days, hours, minutes, seconds, ms, us or ns", plain(word)));
  if (since == std::string::npos) return TimeUnits{*unit};
  const std::string instant(trimmed(std::string_view(text).substr(since + kSince.size())));
  if (const auto time = parse_reference_time(instant, early)) return TimeUnits{*unit, time};
  return tl::unexpected(
      fmt::format("\"{}\" is not a time, expected one like \"2026-03-01 12:00:00 +1:00\"", plain(instant)));
}

/// Returns the fill value that the library stores where nothing was written. The byte types have none.
std::optional<double> default_fill(nc_type type) {
  switch (type) {
    case NC_SHORT: return NC_FILL_SHORT;
    case NC_INT: return NC_FILL_INT;
    case NC_FLOAT: return NC_FILL_FLOAT;
    case NC_DOUBLE: return NC_FILL_DOUBLE;
    case NC_USHORT: return NC_FILL_USHORT;
    case NC_UINT: return NC_FILL_UINT;
    case NC_INT64: return static_cast<double>(NC_FILL_INT64);
    case NC_UINT64: return static_cast<double>(NC_FILL_UINT64);
    default: return std::nullopt;
  }
}

template <class T>
double as(double number) {
  const double whole = std::trunc(number);
  const bool fits = whole >= static_cast<double>(std::numeric_limits<T>::min()) &&
                    whole <= static_cast<double>(std::numeric_limits<T>::max());
  return fits ? whole : number;  // outside the type: matches no number
}

/// Returns a number as a variable of that type stores it: 0.1 as a float differs from 0.1 as a double.
double round_to_type(nc_type type, double number) {
  switch (type) {
    case NC_FLOAT: return static_cast<float>(number);
    case NC_BYTE: return as<std::int8_t>(number);
    case NC_UBYTE: return as<std::uint8_t>(number);
    case NC_SHORT: return as<std::int16_t>(number);
    case NC_USHORT: return as<std::uint16_t>(number);
    case NC_INT: return as<std::int32_t>(number);
    case NC_UINT: return as<std::uint32_t>(number);
    case NC_INT64: return as<std::int64_t>(number);
    case NC_UINT64: return as<std::uint64_t>(number);
    default: return number;
  }
}

/// A variable with its conversion from stored numbers to values.
struct Variable {
  int id{};
  /// The dimension of the rows: its index in the variable, and its id in the file.
  int axis = 0, dimension = -1;
  nc_type type{};
  double scale = 1, offset = 0;
  std::vector<double> no_values{};  ///< numbers that mark missing values
  double valid_low = -std::numeric_limits<double>::infinity(), valid_high = std::numeric_limits<double>::infinity();

  [[nodiscard]] double value(double number) const {
    const bool is_there = std::isfinite(number) && number >= valid_low && number <= valid_high &&
                          std::ranges::find(no_values, number) == no_values.end();
    return is_there ? number * scale + offset : kMissing;
  }
  [[nodiscard]] bool is_packed() const { return scale != 1 || offset != 0; }
  /// Returns whether the variable's numbers may be too large to be exact in a double.
  [[nodiscard]] bool is_long() const { return type == NC_INT64 || type == NC_UINT64; }
};

/// Converts a number to a time through its shortest decimal form: "0.1" and not the nearest binary fraction. The
/// decimal form is the intended time, and differences of two such times are exact.
CountedTime counted_time(double number, const Variable& variable, Duration unit) {
  std::array<char, 32> text{};
  const bool is_float = variable.type == NC_FLOAT && !variable.is_packed();
  const auto* end = is_float ? fmt::format_to(text.data(), "{}", static_cast<float>(number))
                             : fmt::format_to(text.data(), "{}", number);
  const auto counted = parse_counted_time({text.data(), static_cast<std::size_t>(end - text.data())}, unit);
  return counted ? *counted : exchange::counted_time(number, unit);
}

class NetcdfTable {
 public:
  /// Creates a table. It calls `step` before each call of the library that may take long.
  NetcdfTable(std::string path, const std::function<void()>& step) : path_(std::move(path)), step_(step) {}
  ~NetcdfTable() {
    if (file_ >= 0) nc_close(file_);
  }
  NetcdfTable(const NetcdfTable&) = delete;
  NetcdfTable& operator=(const NetcdfTable&) = delete;

  Result<void> open(const ImportMap& map) {
    if (auto opened = open_file(); !opened) return opened;
    const auto time = find(map.time->name);
    if (!time) return missing_columns_failure({map.time->name}, {});
    dimension_ = time->dimension;
    if (auto size = check(nc_inq_dimlen(file_, *dimension_, &rows_)); !size) return size;
    time_ = *time;
    if (auto checked = check_numbers(time_, map.time->name); !checked) return checked;
    if (auto units = read_units(map.time->name, map.file_units); !units) return units;
    return find_columns(map);
  }

  /// Opens the file and returns its global attribute `source`; an empty text if it has none, or none that is a text.
  Result<std::string> read_source() {
    if (auto opened = open_file(); !opened) return failure(opened.error());
    return text_attribute(NC_GLOBAL, "source", "the file").value_or("");
  }

  /// Returns a line of fields, separated by tabs, per variable of a file that gyrotherm exported.
  Result<std::string> describe_own_variables() {
    if (auto opened = open_file(); !opened) return failure(opened.error());
    const auto history = text_attribute(NC_GLOBAL, "history", "the file").value_or("");
    const auto time = find("time");
    if (!history.starts_with("made by gyrotherm ") || !time) return "";
    dimension_ = time->dimension;
    constexpr std::size_t kMaxListLength = 1 << 14;
    std::string lines;
    for (const auto& name : list_row_variables({})) {
      const auto variable = find(name);
      if (!variable) continue;
      lines += plain(name);
      for (const char* attribute : {"units", "long_name", "channel"})
        lines += "\t" + plain(text_attribute(variable->id, attribute, name).value_or(""));
      for (const char* attribute : {"gradients", "three_point"})
        lines += "\t" + plain(text_attribute(variable->id, attribute, name, kMaxListLength).value_or(""));
      for (const char* attribute : {"earth_rate_deg_per_h", "arcsec_per_pulse"}) {
        const auto numbers = numbers_of_attribute(variable->id, attribute);
        lines += numbers.size() == 1 ? fmt::format("\t{}", numbers.front()) : "\t";
      }
      lines += "\n";
    }
    return lines;
  }

  Result<void> read(const TakeRow& take) {
    constexpr std::size_t kRowsAtOnce = 1 << 14;
    std::vector<double> numbers(columns_.size());
    for (std::size_t first = 0; first < rows_; first += kRowsAtOnce) {
      const std::size_t count = std::min(kRowsAtOnce, rows_ - first);
      if (auto read = read_part(first, count); !read) return read;
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t column = 0; column < columns_.size(); ++column) numbers[column] = part_[column][i];
        if (auto taken = take_row(first + i, times_[i], numbers, take); !taken) return taken;
      }
    }
    return rows_ > 0 ? Result<void>{} : bad_file_failure("the file has no row, expected at least one");
  }

 private:
  tl::unexpected<Fault> bad_file_failure(const std::string& what) const {
    return failure(FaultKind::bad_file, path_, plain(what, Blanks::kept));
  }
  Result<void> open_file() {
    step_();
    return check(nc_open(path_.c_str(), NC_NOWRITE, &file_));
  }
  Result<void> check(int error) const {
    return error == NC_NOERR ? Result<void>{}
                             : bad_file_failure(std::string("cannot be read as NetCDF or HDF5: ") + nc_strerror(error));
  }

  /// Names the columns that the file does not have, the variables that can be read, and what else the file contains.
  tl::unexpected<Fault> missing_columns_failure(const std::vector<std::string>& missing,
                                                const std::vector<std::string>& used) const {
    const auto available = list_row_variables(used);
    std::string what = available.empty() ? fmt::format("no column \"{}\"", fmt::join(missing, "\", \""))
                                         : describe_missing_columns(missing, available);
    if (const auto others = list_unreadable(); !others.empty())
      what += fmt::format(
          "; the file has {}; only vectors at its top level can be read, such as those of \"t = rec.t; "
          "save('flat.mat', "
          "'t', '-v7.3')\" in MATLAB",
          fmt::join(others, ", "));
    return bad_file_failure(what);
  }

  /// Describes the groups with their variables, and the variables that are not vectors: "data 3×3960".
  std::vector<std::string> list_unreadable() const {
    constexpr std::size_t kMaxListed = 40;
    std::vector<std::string> found;
    std::array<int, kMaxListed> groups{};
    int count = 0;
    if (nc_inq_grps(file_, &count, nullptr) == NC_NOERR && count > 0 && count <= static_cast<int>(kMaxListed) &&
        nc_inq_grps(file_, &count, groups.data()) == NC_NOERR) {
      for (int i = 0; i < count; ++i) {
        const int group = groups[static_cast<std::size_t>(i)];
        std::array<char, NC_MAX_NAME + 1> name{};
        if (nc_inq_grpname(group, name.data()) != NC_NOERR || name[0] == '#') continue;  // MATLAB's own group
        found.push_back(fmt::format("the group \"{}\" ({})", name.data(),
                                    fmt::join(list_shapes(group, [](int) { return true; }), ", ")));
      }
    }
    for (auto& shape : list_shapes(file_, [&](int id) { return !is_vector(id); })) found.push_back(std::move(shape));
    return found;
  }

  bool is_vector(int id) const {
    int rank = 0;
    std::array<int, 2> dimensions{};
    return nc_inq_varndims(file_, id, &rank) == NC_NOERR && find_axis(id, rank, dimensions);
  }

  /// Returns name and shape of the selected variables of a group.
  static std::vector<std::string> list_shapes(int group, const std::function<bool(int)>& selects) {
    constexpr int kMaxListed = 40;
    std::vector<std::string> shapes;
    int count = 0;
    if (nc_inq_nvars(group, &count) != NC_NOERR) return shapes;
    for (int id = 0; id < std::min(count, kMaxListed); ++id) {
      std::array<char, NC_MAX_NAME + 1> name{};
      int rank = 0;
      std::array<int, NC_MAX_VAR_DIMS> dimensions{};
      if (!selects(id) || nc_inq_varname(group, id, name.data()) != NC_NOERR ||
          nc_inq_varndims(group, id, &rank) != NC_NOERR || nc_inq_vardimid(group, id, dimensions.data()) != NC_NOERR)
        continue;
      std::vector<std::size_t> lengths(static_cast<std::size_t>(std::max(rank, 0)));
      for (std::size_t i = 0; i < lengths.size(); ++i) nc_inq_dimlen(group, dimensions[i], &lengths[i]);
      shapes.push_back(fmt::format("\"{}\" {}", name.data(),
                                   lengths.empty() ? "scalar" : fmt::format("{}", fmt::join(lengths, "×"))));
    }
    return shapes;
  }

  /// Returns the index of the only dimension longer than 1, or the first of dimensions of length 1. Returns nothing for
  /// other variables.
  std::optional<int> find_axis(int id, int rank, std::array<int, 2>& dimensions) const {
    std::array<std::size_t, 2> lengths{1, 1};
    if (rank < 1 || rank > 2 || nc_inq_vardimid(file_, id, dimensions.data()) != NC_NOERR) return std::nullopt;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rank); ++i)
      if (nc_inq_dimlen(file_, dimensions[i], &lengths[i]) != NC_NOERR) return std::nullopt;
    if (rank == 1 || lengths[1] == 1) return 0;
    return lengths[0] == 1 ? std::optional(1) : std::nullopt;
  }

  /// Returns the variable with this id if it is numeric and extends along only one dimension. Once the time dimension
  /// is known, the variable must have that dimension.
  std::optional<Variable> find_row_variable(int id) const {
    int rank = 0;
    nc_type type{};
    std::array<int, 2> dimensions{};
    if (nc_inq_var(file_, id, nullptr, &type, &rank, nullptr, nullptr) != NC_NOERR) return std::nullopt;
    const auto axis = find_axis(id, rank, dimensions);
    if (!axis) return std::nullopt;
    const int dimension = dimensions[static_cast<std::size_t>(*axis)];
    const bool is_number = type != NC_CHAR && type != NC_STRING && type <= NC_MAX_ATOMIC_TYPE;
    if (!is_number || (dimension_ && dimension != *dimension_)) return std::nullopt;
    Variable variable{.id = id, .axis = *axis, .dimension = dimension, .type = type};
    if (const auto scale = numbers_of_attribute(id, "scale_factor"); !scale.empty()) variable.scale = scale.front();
    if (const auto offset = numbers_of_attribute(id, "add_offset"); !offset.empty()) variable.offset = offset.front();
    variable.no_values = numbers_of_attribute(id, "_FillValue");
    if (const auto fill = default_fill(type); fill && variable.no_values.empty()) variable.no_values.push_back(*fill);
    for (const double missing : numbers_of_attribute(id, "missing_value")) variable.no_values.push_back(missing);
    for (double& number : variable.no_values) number = round_to_type(type, number);
    const auto bound = [&](const char* name, std::size_t at, double& limit) {
      if (const auto numbers = numbers_of_attribute(id, name); numbers.size() > at)
        limit = round_to_type(type, numbers[at]);
    };
    bound("valid_min", 0, variable.valid_low);
    bound("valid_max", 0, variable.valid_high);
    bound("valid_range", 0, variable.valid_low);
    bound("valid_range", 1, variable.valid_high);
    return variable;
  }

  std::optional<Variable> find(const std::string& name) const {
    int id = -1;
    if (nc_inq_varid(file_, name.c_str(), &id) != NC_NOERR) return std::nullopt;
    return find_row_variable(id);
  }

  std::vector<std::string> list_row_variables(const std::vector<std::string>& but) const {
    std::vector<std::string> names;
    int count = 0;
    if (nc_inq_nvars(file_, &count) != NC_NOERR) return names;
    for (int id = 0; id < count; ++id) {
      std::array<char, NC_MAX_NAME + 1> name{};
      if (find_row_variable(id) && nc_inq_varname(file_, id, name.data()) == NC_NOERR &&
          std::ranges::find(but, name.data()) == but.end())
        names.emplace_back(name.data());
    }
    return names;
  }

  /// Returns the numbers of an attribute; empty if it is missing or not numeric.
  std::vector<double> numbers_of_attribute(int variable, const char* name) const {
    constexpr std::size_t kMaxNumbers = 1000;
    std::size_t length = 0;
    nc_type type{};
    if (nc_inq_att(file_, variable, name, &type, &length) != NC_NOERR || length > kMaxNumbers || type == NC_CHAR ||
        type >= NC_STRING)
      return {};
    std::vector<double> numbers(length);
    if (nc_get_att_double(file_, variable, name, numbers.data()) != NC_NOERR) return {};
    return numbers;
  }

  /// Checks that the attributes for packing and for missing values can be read. Without this check, stored numbers
  /// would be used as values.
  Result<void> check_numbers(const Variable& variable, const std::string& column) const {
    const auto is_there = [&](const char* name) {
      return nc_inq_attlen(file_, variable.id, name, nullptr) == NC_NOERR;
    };
    for (const char* name : {"scale_factor", "add_offset"})
      if (is_there(name) && numbers_of_attribute(variable.id, name).size() != 1)
        return bad_file_failure(
            fmt::format("the attribute {} of \"{}\" is not a single number, expected one", name, column));
    for (const char* name : {"_FillValue", "missing_value"})
      if (is_there(name) && numbers_of_attribute(variable.id, name).empty())
        return bad_file_failure(fmt::format(
            "the attribute {} of \"{}\" is not a number, expected a number of the variable's type", name, column));
    return {};
  }

  /// Returns an attribute that is a text or a single string; empty if it is missing.
  Result<std::string> text_attribute(int variable, const char* name, const std::string& column,
                                     std::size_t max_length = 1000) const {
    std::size_t length = 0;
    nc_type type{};
    if (nc_inq_att(file_, variable, name, &type, &length) != NC_NOERR) return "";
    if (type == NC_STRING && length == 1) {
      char* string = nullptr;
      if (auto read = check(nc_get_att_string(file_, variable, name, &string)); !read) return failure(read.error());
      std::string text = string == nullptr ? "" : string;
      nc_free_string(1, &string);
      return text.substr(0, max_length);
    }
    if (type != NC_CHAR || length > max_length)
      return bad_file_failure(fmt::format(
          "the attribute {} of \"{}\" is not a text of at most {} characters, expected one", name, column, max_length));
    std::string text(length, '\0');
    if (auto read = check(nc_get_att_text(file_, variable, name, text.data())); !read) return failure(read.error());
    return text.substr(0, text.find('\0'));
  }

  Result<void> read_units(const std::string& name, const std::string& map_units) {
    auto units = text_attribute(time_.id, "units", name);
    const auto calendar = text_attribute(time_.id, "calendar", name);
    if (!units) return failure(units.error());
    if (!map_units.empty() && !units->empty())
      return bad_file_failure(fmt::format("\"{}\" has the units \"{}\", expected no unit in the map", name, *units));
    if (units->empty()) units = map_units;
    if (units->empty())
      return bad_file_failure(
          fmt::format("\"{}\" has no units, expected unit = \"s\" or the like in [time] of the map", name));
    if (!calendar) return failure(calendar.error());
    const auto parsed =
        parse_time_units(*units, *calendar == "proleptic_gregorian" ? EarlyDays::gregorian : EarlyDays::julian);
    if (!parsed) return bad_file_failure(fmt::format("\"{}\" has the units \"{}\": {}", name, *units, parsed.error()));
    for (const char* usual : {"", "standard", "gregorian", "proleptic_gregorian", "none"})
      if (*calendar == usual) units_ = *parsed;
    if (units_.unit > Duration{}) return {};
    return bad_file_failure(fmt::format("\"{}\" has the calendar \"{}\", expected the standard one", name, *calendar));
  }

  /// Checks that the scale in the map agrees with the units in the file. Allows differences that a calibration can
  /// cause.
  Result<void> check_units(const ImportMap& map) {
    for (std::size_t i = 0; i < map.thermometer_columns.size(); ++i) {
      const auto& [column, scale, offset, valid] = map.thermometer_columns[i];
      const auto units = text_attribute(columns_[i].id, "units", column.name);
      const auto stated = units && !units->empty() ? celsius_scale(*units) : std::nullopt;
      constexpr double kMaxScaleCorrection = 0.2, kMaxOffsetCorrection_k = 20;
      if (stated && (std::abs(scale / stated->scale - 1) > kMaxScaleCorrection ||
                     std::abs(offset - stated->offset) > kMaxOffsetCorrection_k))
        return bad_file_failure(
            fmt::format("\"{}\" has the units \"{}\", expected scale = {:.15g} and offset = {:.15g} in the map",
                        column.name, *units, stated->scale, stated->offset));
    }
    auto column = columns_.begin() + static_cast<std::ptrdiff_t>(map.thermometer_columns.size());
    auto name = map.axis_columns.begin();
    for (const auto& unit : map.units)
      for (const auto& axis : unit.axes) {
        const auto units = text_attribute((column++)->id, "units", name->name);
        const auto stated = units && !units->empty() ? degrees_per_hour_in("w [" + *units + "]") : std::nullopt;
        constexpr double kMaxScaleCorrection = 0.2;
        if (stated && axis.kind == record::GyroKind::rate &&
            std::abs(std::abs(axis.scale) / *stated - 1) > kMaxScaleCorrection)
          return bad_file_failure(fmt::format("\"{}\" has the units \"{}\", expected scale = {:.15g} in the map",
                                              name->name, *units, *stated));
        ++name;
      }
    return check_interval_units(map);
  }

  /// Fails if a variable of counting times states another unit than seconds.
  Result<void> check_interval_units(const ImportMap& map) const {
    const auto names = map.columns();
    const auto first = map.thermometer_columns.size() + map.axis_columns.size() + map.value_columns.size();
    for (std::size_t i = first; i < names.size(); ++i) {
      const auto units = text_attribute(columns_[i].id, "units", names[i].name);
      if (!units || units->empty()) continue;
      const auto parsed = parse_time_units(*units, EarlyDays::julian);
      if (!parsed || parsed->unit != kSecond)
        return bad_file_failure(fmt::format("\"{}\" has the units \"{}\", expected \"s\"", names[i].name, *units));
    }
    return {};
  }

  Result<void> find_columns(const ImportMap& map) {
    std::vector<std::string> missing;
    for (const ColumnName& column : map.columns())
      if (const auto found = find(column.name)) {
        columns_.push_back(*found);
        if (auto checked = check_numbers(*found, column.name); !checked) return checked;
      } else {
        missing.push_back(column.name);
      }
    if (missing.empty()) return check_units(map);
    return missing_columns_failure(missing, {map.time->name});
  }

  Result<void> read_part(std::size_t first, std::size_t count) {
    part_.resize(columns_.size());
    for (std::size_t i = 0; i < part_.size(); ++i)
      if (auto read = read_values(columns_[i], first, count, part_[i]); !read) return read;
    return time_.is_long() && !time_.is_packed() ? read_whole_times(first, count) : read_times(first, count);
  }

  // The library reports numbers outside the requested type and stores the nearest one.
  Result<void> check_read(int error) const { return error == NC_ERANGE ? Result<void>{} : check(error); }

  /// The start and the count of some rows of a variable, per dimension.
  struct Part {
    Part(const Variable& variable, std::size_t first, std::size_t count) {
      starts[static_cast<std::size_t>(variable.axis)] = first;
      counts[static_cast<std::size_t>(variable.axis)] = count;
    }
    std::array<std::size_t, 2> starts{0, 0}, counts{1, 1};
  };

  Result<void> read_values(const Variable& variable, std::size_t first, std::size_t count,
                           std::vector<double>& values) const {
    values.resize(count);
    step_();
    const Part part(variable, first, count);
    auto read =
        check_read(nc_get_vara_double(file_, variable.id, part.starts.data(), part.counts.data(), values.data()));
    for (double& number : values) number = variable.value(number);
    return read;
  }

  Result<void> read_times(std::size_t first, std::size_t count) {
    std::vector<double> numbers;
    if (auto read = read_values(time_, first, count, numbers); !read) return read;
    times_.clear();
    for (const double number : numbers)
      times_.push_back(std::isnan(number) ? std::nullopt : std::optional(counted_time(number, time_, units_.unit)));
    return {};
  }

  Result<void> read_whole_times(std::size_t first, std::size_t count) {
    std::vector<long long> numbers(count);
    step_();
    const Part part(time_, first, count);
    if (auto read =
            check_read(nc_get_vara_longlong(file_, time_.id, part.starts.data(), part.counts.data(), numbers.data()));
        !read)
      return read;
    times_.clear();
    for (const std::int64_t number : numbers)
      times_.push_back(std::isnan(time_.value(static_cast<double>(number)))
                           ? std::nullopt
                           : std::optional(exchange::counted_time(number, units_.unit)));
    return {};
  }

  Result<void> take_row(std::size_t row, const std::optional<CountedTime>& time, const std::vector<double>& numbers,
                        const TakeRow& take) {
    const auto of_row = [&](std::string what) {
      return failure(FaultKind::bad_file, fmt::format("{}: row {}", path_, row), std::move(what));
    };
    if (time && !first_) first_ = *time;
    const auto since_first = time ? duration_between(*first_, *time) : std::nullopt;
    if (!since_first) return of_row("no time, or more than ten years after the first row");
    ForeignRow foreign{.time = *since_first, .numbers = numbers};
    if (units_.since) {
      foreign.utc = to_utc(*units_.since + *time);
      if (!foreign.utc) return of_row("a time outside 1970 to 2116");
    }
    return take(foreign);
  }

  std::string path_;
  const std::function<void()>& step_;
  int file_ = -1;
  std::optional<int> dimension_{};
  std::size_t rows_{};
  Variable time_{};
  TimeUnits units_{};
  std::vector<Variable> columns_{};
  // The values and times of some consecutive rows.
  std::vector<std::vector<double>> part_{};  ///< per column
  std::vector<std::optional<CountedTime>> times_{};
  std::optional<CountedTime> first_{};
};

constexpr const char* kLibrary = "the NetCDF library";

}  // namespace

bool is_netcdf(std::string_view beginning) {
  constexpr std::string_view kHdf5 = "\x89HDF\r\n\x1A\n";
  constexpr std::size_t kBlock = 512;
  if (beginning.size() > kBlock && beginning.substr(kBlock).starts_with(kHdf5)) return true;
  return beginning.starts_with(kHdf5) || beginning.starts_with("CDF\x01") || beginning.starts_with("CDF\x02") ||
         beginning.starts_with("CDF\x05");
}

Result<void> read_netcdf(const std::string& path, const ImportMap& map, const TakeRow& take,
                         const ReadingLimits& limits) {
  const auto bytes = Bytes::open(path);
  if (!bytes) return failure(bytes.error());
  if (bytes->is_packed())
    return failure(FaultKind::bad_file, path,
                   "gzip: a compressed NetCDF file cannot be read; unpack it first, \"gunzip -k FILE\"");
  const auto read = [&](const TakeRow& take_in_child, const std::function<void()>& step) {
    NetcdfTable table(path, step);
    return table.open(map).and_then([&] { return table.read(take_in_child); });
  };
  return read_confined(path, kLibrary, map.columns().size(), read, take, limits);
}

Result<std::string> read_netcdf_source(const std::string& path) {
  return read_text_confined(path, kLibrary,
                            [&](const std::function<void()>& step) { return NetcdfTable(path, step).read_source(); });
}

Result<std::vector<NetcdfVariable>> list_own_variables(const std::string& path) {
  const auto lines = read_text_confined(path, kLibrary, [&](const std::function<void()>& step) {
    return NetcdfTable(path, step).describe_own_variables();
  });
  if (!lines) return failure(lines.error());
  std::vector<NetcdfVariable> variables;
  std::string_view rest = *lines;
  const auto take_until = [&](char end) {
    const auto length = std::min(rest.find(end), rest.size());
    std::string field(rest.substr(0, length));
    rest.remove_prefix(std::min(length + 1, rest.size()));
    return field;
  };
  while (!rest.empty()) {
    NetcdfVariable& variable = variables.emplace_back();
    for (std::string* field : {&variable.name, &variable.units, &variable.long_name, &variable.channel,
                               &variable.gradients, &variable.three_point, &variable.earth_rate})
      *field = take_until('\t');
    variable.arcsec_per_pulse = take_until('\n');
  }
  return variables;
}

}  // namespace gyrotherm::exchange
