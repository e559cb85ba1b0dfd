// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/guess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <set>
#include <vector>

#include "acquisition/exchange/column_names.hpp"
#include "acquisition/exchange/dataflash.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/lvm_layout.hpp"
#include "acquisition/exchange/netcdf_table.hpp"
#include "acquisition/exchange/own_export.hpp"
#include "acquisition/exchange/table_sample.hpp"
#include "acquisition/exchange/time_guess.hpp"
#include "acquisition/exchange/ulog.hpp"
#include "acquisition/record/schema.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

using Columns = std::vector<std::size_t>;

/// A format that is not supported, and how to convert it to a supported one.
struct KnownFormat {
  std::string_view beginning;
  std::string_view conversion;
};

constexpr std::string_view kZip("PK\x03\x04", 4);

constexpr std::array<KnownFormat, 14> kKnown{{
    {std::string_view("BZh", 3), "bzip2: unpack it first, \"bunzip2 -k FILE\""},
    {std::string_view("\xFD"
                      "7zXZ\0",
                      6),
     "xz: unpack it first, \"unxz -k FILE\""},
    {std::string_view("\x28\xB5\x2F\xFD", 4), "zstd: unpack it first, \"unzstd FILE\""},
    {std::string_view("7z\xBC\xAF\x27\x1C", 6), "a 7-Zip archive: unpack it first"},
    {std::string_view("Rar!\x1A", 5), "a RAR archive: unpack it first"},
    {std::string_view("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", 8),
     "an old Excel workbook (xls): save the sheet as CSV, \"soffice --convert-to csv FILE\""},
    {"MATLAB 5.0 MAT-file", "a MATLAB file of version 5 to 7: save the table as CSV, \"writetable(T, 'file.csv')\""},
    {"MDF     ", "MDF (vehicle measurements): convert it to CSV, with asammdf \"mdf.export('csv')\""},
    {"TDSm", "LabVIEW TDMS: convert it to CSV, with npTDMS \"tdmsinfo\" and \"as_dataframe().to_csv()\""},
    {"PAR1", "Parquet: convert it to CSV, with pandas \"read_parquet('FILE').to_csv('file.csv')\""},
    {std::string_view("ARROW1", 6),
     "Arrow: convert it to CSV, with pandas \"read_feather('FILE').to_csv('file.csv')\""},
    {std::string_view("SQLite format 3\0", 16),
     "an SQLite file; a gyrotherm record needs no import; export a table of any other database as CSV"},
    {"%PDF", "a PDF: obtain the table as CSV"},
    {"#ROSBAG", "a ROS bag: export the topic as CSV, \"rostopic echo -b FILE -p TOPIC\""},
}};

/// Describes a format that is not supported, and how to convert the file: "a zip archive: unpack it first". Returns an
/// empty text for any other file.
std::string conversion_advice(std::string_view beginning) {
  if (beginning.starts_with(kZip)) {
    const bool is_workbook = beginning.find("[Content_Types].xml") != std::string_view::npos ||
                             beginning.find("xl/") != std::string_view::npos ||
                             beginning.find("_rels/.rels") != std::string_view::npos;
    return is_workbook ? "an Excel workbook (xlsx): save the sheet as CSV, \"soffice --convert-to csv FILE\""
                       : "a zip archive: unpack it first, \"unzip FILE\"";
  }
  for (const KnownFormat& known : kKnown)
    if (beginning.starts_with(known.beginning)) return std::string(known.conversion);
  if (beginning.size() >= 262 && beginning.substr(257).starts_with("ustar"))
    return "a tar archive: unpack it first, \"tar -xf FILE\"";
  return "";
}

std::string file_section(const TableSample& sample) {
  const auto& style = sample.style;
  std::string text =
      fmt::format("[file]\nseparator = {}\n", sample.separator == '\t' ? "\"\\t\"" : toml_text({&sample.separator, 1}));
  if (style.decimal == ',') text += "decimal = \",\"\n";
  if (sample.is_decimal_doubtful)
    text +=
        "decimal = \"?\"        # is \"1,234\" 1234 or 1.234? Write thousands = \",\" or "
        "decimal = \",\"\n";
  if (style.thousands != 0)
    text +=
        fmt::format("thousands = {}        # separates the thousands of a number\n", toml_text({&style.thousands, 1}));
  if (!style.units.empty()) {
    text += "cell_units = [";
    for (const auto& unit : style.units) text += (&unit == &style.units.front() ? "" : ", ") + toml_text(unit);
    text += "]        # units after numbers\n";
  }
  if (!sample.comment.empty()) text += fmt::format("comment = {}\n", toml_text(sample.comment));
  if (sample.preamble > 0) text += fmt::format("preamble = {}        # lines before the header\n", sample.preamble);
  if (!sample.header) text += "header = false\n";
  if (sample.skip > 0)
    text += fmt::format("skip = {}        # {}\n", sample.skip,
                        sample.header ? "lines after the header that are not rows" : "lines before the first row");
  if (sample.is_lvm)
    text += fmt::format("segment = [\"{}\", \"{}\"]        # a header between rows\n", kLvmSegment, kLvmHeaderEnd);
  if (sample.damaged > 0)
    text += fmt::format(
        "damaged = \"skip\"        # {} of the lines cannot be read, the first is line {}: they are left "
        "out and counted\n",
        sample.damaged, sample.first_damaged);
  if (sample.missing.empty()) return text;
  text += "missing = [";
  for (const auto& field : sample.missing)
    text += fmt::format("{}{}", &field == &sample.missing.front() ? "" : ", ", toml_text(field));
  return text + "]        # fields in number columns that are not numbers\n";
}

/// Returns the lines that convert the column of a thermometer to °C: the scale of a known unit, or a comment if the
/// name has no unit or an unknown one. `usual` is the unit if the name has none: °C in logs.
std::string celsius_lines(const std::string& name, std::string_view usual) {
  std::string unit = temperature_unit_in(name);
  if (unit.empty()) unit = usual;
  if (unit == "°C") return "\n";
  if (unit == "K") return "\noffset = -273.15        # from K\n";
  if (const auto scale = unit.empty() ? std::nullopt : celsius_scale(unit)) {
    std::string text = fmt::format("\nscale = {:.15g}        # of {}\n", scale->scale, plain(unit));
    if (scale->offset != 0) text += fmt::format("offset = {:.15g}\n", scale->offset);
    return text;
  }
  const auto remark = unit.empty() ? "a guess, taken as °C" : fmt::format("a guess, \"{}\" is not known", plain(unit));
  return fmt::format("        # {}: °C = number × scale + offset\n", remark);
}

/// Generates unique names of thermometers.
class ThermometerNames {
 public:
  ThermometerNames() : taken_(record::reserved_channel_names()) {
    taken_.insert({"pulses", "interval_ns"});  // columns of an unnamed gyro
  }
  std::string next(const std::string& column) {
    std::string name = channel_name_for(column);
    while (name.empty() || !taken_.insert(in_lower_case(name)).second) name += "T";
    return name;
  }

 private:
  std::set<std::string> taken_;
};

std::string thermometer_sections(const TableSample& sample, const Columns& columns) {
  std::string text;
  ThermometerNames names;
  for (const std::size_t column : columns) {
    const auto name = sample.column_name(column);
    text += fmt::format("\n[[thermometer]]\nname = {}\n{}{}", toml_text(names.next(name)), sample.reference(column),
                        celsius_lines(name, ""));
  }
  return text;
}

/// Returns the lines of one axis: its column, its kind and its scale.
std::string axis_lines(const std::string& column, bool is_increment, std::optional<double> scale) {
  const char* per = is_increment ? "arcsec" : "°/h";
  return fmt::format("{}\nkind = \"{}\"\nscale = {:.15g}        # {} per unit of the column{}\n", column,
                     is_increment ? "increment" : "rate", scale.value_or(1), per, scale ? "" : ": a guess, correct it");
}

/// The gyro section of a draft map if no gyro was found.
constexpr const char* kUnknownGyro =
    "\n[gyro]\ncolumn = \"\"        # which column is the gyro's?\nkind = \"rate\"\nscale = 1        # °/h per unit of "
    "the column\n";

/// Builds the sections of a gyro's axes, and gives each axis a unique name.
class AxisSections {
 public:
  void add(const std::string& title, const std::string& lines) {
    std::string axis = axis_in(title);
    while (axis.empty() || !taken_.insert(axis).second) axis += std::to_string(taken_.size() + 1);
    text_ += fmt::format("\n[[gyro.axis]]\nname = \"{}\"\n", axis) + lines;
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::set<std::string> taken_{};
  std::string text_{};
};

std::string gyro_section(const TableSample& sample, const Columns& columns) {
  if (columns.empty()) return kUnknownGyro;
  const bool are_increments = sample.header && std::ranges::all_of(columns, [&](std::size_t column) {
                                return is_increment_name(sample.column_name(column));
                              });
  const auto lines = [&](std::size_t column) {
    const auto name = sample.column_name(column);
    return axis_lines(sample.reference(column), are_increments,
                      are_increments ? std::nullopt : degrees_per_hour_in(name));
  };
  const bool has_names = std::ranges::any_of(sample.names, [](const std::string& name) { return !name.empty(); });
  if (!has_names)
    return fmt::format(
        "\n# The columns have no names: the last one is a guess. Which of columns 1 to {} is the gyro's?\n[gyro]\n{}",
        sample.names.size(), lines(columns.front()));
  if (columns.size() == 1) return "\n[gyro]\n" + lines(columns.front());
  AxisSections axes;
  for (const std::size_t column : columns) axes.add(sample.column_name(column), lines(column));
  return "\n[[gyro]]\nname = \"imu\"\n" + axes.text();
}

std::string map_head(const std::string& file, const std::vector<std::string>& names) {
  constexpr std::size_t kMaxListedNames = 400, kMaxLineWidth = 100;
  const std::filesystem::path path = file;
  const auto name = plain(path.filename().string()), map_name = plain(path.stem().string());
  std::string text = fmt::format("# Draft map of {}, detected automatically; check every line. Columns of the file:\n",
                                 name),
              line;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxListedNames); ++i) {
    if (line.size() > kMaxLineWidth) {
      text += "#  " + line + "\n";
      line.clear();
    }
    line += " " + toml_text(names[i]);
  }
  text += "#  " + line + (names.size() > kMaxListedNames ? " …\n" : "\n");
  return text + fmt::format("schema = \"{}\"\nname = {}\n\n", kImportSchema, toml_text(map_name));
}

bool contains(const Columns& columns, std::size_t column) {
  return std::ranges::find(columns, column) != columns.end();
}

std::string table_map(const TableSample& sample, const std::string& file) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < sample.names.size(); ++i) names.push_back(sample.column_name(i));
  if (const auto own = find_own_columns(sample.names, sample.comments))
    return map_head(file, names) + file_section(sample) + "\n" + own_sections(*own);
  const bool has_names = std::ranges::any_of(sample.names, [](const std::string& name) { return !name.empty(); });
  const auto has_numbers = [&](std::size_t column) { return !sample.column_numbers(column).empty(); };
  Columns gyros = has_names ? gyro_columns(names) : Columns{};
  std::erase_if(gyros, [&](std::size_t column) { return !has_numbers(column) || is_time_name(names[column]); });
  Columns thermometers;
  for (std::size_t i = 0; has_names && i < names.size(); ++i)
    if (is_temperature_name(names[i]) && !contains(gyros, i) && has_numbers(i)) thermometers.push_back(i);
  const TimeGuess time = guess_time(sample, thermometers);
  const auto is_of_time = [&](std::size_t column) { return contains(time.columns, column); };
  std::erase_if(gyros, is_of_time);
  std::erase_if(thermometers, is_of_time);
  if (!has_names) gyros.assign(1, names.size() - 1);
  return map_head(file, names) + file_section(sample) + "\n" + time.text + thermometer_sections(sample, thermometers) +
         gyro_section(sample, gyros);
}

/// A gyro of a log, with its own temperature.
struct LoggedGyro {
  std::string name{};  ///< "imu", "imu1"
  /// The columns of x, y and z.
  std::vector<std::string> axes{};
  /// The column of its temperature; empty if there is none.
  std::string temperature{};
};

/// The columns of a log for a draft map.
struct LogGuess {
  std::vector<LoggedGyro> gyros{};
  std::vector<std::string> others{};  ///< temperatures in messages without a gyro
};

/// The messages of a log with raw rates, the best first. In old logs a digit after the name is the number of the
/// sensor.
constexpr std::array<std::string_view, 4> kMessages{"sensor_gyro", "sensor_combined", "IMU", "GYR"};

/// Names of the rate fields of x, y and z, one row per notation.
constexpr std::array<std::array<std::string_view, 3>, 3> kAxes{
    {{"x", "y", "z"}, {"gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"}, {"GyrX", "GyrY", "GyrZ"}}};

bool belongs_to(const LogColumn& column, std::string_view message) {
  if (!std::string_view(column.message).starts_with(message)) return false;
  const auto behind = std::string_view(column.message).substr(message.size());
  return behind.find_first_not_of("0123456789") == std::string_view::npos;
}

std::string column_series(const LogColumn& column) { return series_name(column.message, column.instance); }

std::string full_name(const LogColumn& column) { return column_series(column) + "." + column.field; }

/// Finds the rates of one series.
LoggedGyro find_gyro(const std::vector<LogColumn>& columns, const std::string& series) {
  LoggedGyro gyro;
  for (const auto& axes : kAxes)
    for (const std::string_view axis : axes)
      for (const LogColumn& column : columns)
        if (column_series(column) == series && column.field == axis) gyro.axes.push_back(full_name(column));
  for (const LogColumn& column : columns)
    if (column_series(column) == series && (column.field == "temperature" || column.field == "T"))
      gyro.temperature = full_name(column);
  return gyro;
}

std::vector<LoggedGyro> find_gyros(const std::vector<LogColumn>& columns, std::string_view message) {
  std::vector<LoggedGyro> gyros;
  std::vector<std::string> seen;
  for (const LogColumn& column : columns) {
    const auto series = column_series(column);
    if (!belongs_to(column, message) || std::ranges::find(seen, series) != seen.end()) continue;
    seen.push_back(series);
    auto gyro = find_gyro(columns, series);
    if (gyro.axes.empty()) continue;
    gyro.name = gyros.empty() ? "imu" : "imu" + std::to_string(gyros.size());
    gyros.push_back(std::move(gyro));
  }
  return gyros;
}

/// Finds the first message with names that look like a gyro's.
std::vector<LoggedGyro> find_gyros_by_name(const std::vector<LogColumn>& columns) {
  std::vector<std::string> names;
  for (const LogColumn& column : columns) names.push_back(full_name(column));
  LoggedGyro gyro{.name = "imu"};
  for (const std::size_t column : gyro_columns(names)) {
    gyro.axes.push_back(names[column]);
    for (const LogColumn& other : columns)
      if (column_series(other) == column_series(columns[column]) && is_temperature_name(other.field))
        gyro.temperature = full_name(other);
  }
  return gyro.axes.empty() ? std::vector<LoggedGyro>{} : std::vector{gyro};
}

/// Selects the gyros of a log from its published columns: every instance of `sensor_gyro`, or else of
/// `sensor_combined`; for ArduPilot each `IMU`, or else `GYR`; or else the first message with names of a gyro. Never
/// selects filter estimates, integrals, or the times and counts of integrals. The other temperatures come from
/// barometers, which are near the gyro.
LogGuess guess_log(const std::vector<LogColumn>& published) {
  LogGuess guess;
  for (const std::string_view message : kMessages)
    if (guess.gyros.empty()) guess.gyros = find_gyros(published, message);
  if (guess.gyros.empty()) guess.gyros = find_gyros_by_name(published);
  for (const LogColumn& column : published) {
    const bool is_barometer = column.message == "sensor_baro" || belongs_to(column, "BARO");
    if (is_barometer && (column.field == "temperature" || column.field == "Temp"))
      guess.others.push_back(full_name(column));
  }
  return guess;
}

std::string log_map(const std::vector<LogColumn>& columns, FileFormat format, const std::string& file) {
  constexpr double kRadianPerSecond = 206264.80624709636;  // in °/h; both autopilots log radians
  std::vector<std::string> names;
  for (const LogColumn& column : columns) names.push_back(full_name(column));
  const LogGuess guess = guess_log(columns);
  std::string text =
      map_head(file, names) + fmt::format(
                                  "[file]\nformat = \"{}\"\n\n[time]\nevery = \"1 s\"        # messages are "
                                  "combined: means of one second\n",
                                  name(format));
  ThermometerNames thermometers;
  std::vector<std::string> others;
  const auto add_thermometer = [&](const std::string& column) {
    auto plain_name = column;  // for example "sensor_gyro1.temperature"
    std::erase_if(plain_name, [](char c) { return c == '[' || c == ']'; });
    const auto thermometer = thermometers.next(plain_name);
    text += fmt::format("\n[[thermometer]]\nname = {}\ncolumn = {}\n", toml_text(thermometer), toml_text(column));
    return toml_text(thermometer);
  };
  for (const auto& column : guess.others) others.push_back(add_thermometer(column));
  std::vector<std::string> own;
  for (const LoggedGyro& gyro : guess.gyros)
    own.push_back(gyro.temperature.empty() ? "" : add_thermometer(gyro.temperature));
  if (guess.gyros.empty()) return text + kUnknownGyro;
  for (std::size_t i = 0; i < guess.gyros.size(); ++i) {
    auto near = others;
    if (!own[i].empty()) near.insert(near.begin(), own[i]);
    text += fmt::format("\n[[gyro]]\nname = \"{}\"\n", guess.gyros[i].name);
    if (!near.empty()) text += fmt::format("thermometers = [{}]\n", fmt::join(near, ", "));
    AxisSections axes;
    for (const auto& column : guess.gyros[i].axes)
      axes.add(column, axis_lines("column = " + toml_text(column), false,
                                  degrees_per_hour_in(column).value_or(kRadianPerSecond)));
    text += axes.text();
  }
  return text;
}

/// Returns the map of a NetCDF file that gyrotherm exported; empty for any other file.
std::string own_netcdf_map(const std::string& path) {
  const auto variables = list_own_variables(path);
  if (!variables) return "";
  const auto own = find_own_columns(*variables);
  if (!own) return "";
  std::vector<std::string> names;
  for (const NetcdfVariable& variable : *variables) names.push_back(variable.name);
  return map_head(path, names) + "[file]\nformat = \"netcdf\"\n\n" + own_sections(*own);
}

/// Names the variables of a file, as the fault of a missing time column does.
std::string list_netcdf_variables(const std::string& path) {
  ImportMap map;
  map.time = ColumnName{"time column"};
  const auto read = read_netcdf(path, map, [](const ForeignRow&) { return Result<void>(); });
  return read ? "" : read.error().what;
}

Result<std::string> guess(Bytes bytes) {
  const std::string file = bytes.name();
  const auto format = detect_format(bytes);
  if (!format) return failure(format.error());
  switch (*format) {
    case FileFormat::ulog:
    case FileFormat::dataflash: {
      const bool is_px4 = *format == FileFormat::ulog;
      const auto columns = is_px4 ? read_ulog_columns(std::move(bytes)) : read_dataflash_columns(std::move(bytes));
      return columns ? Result<std::string>(log_map(*columns, *format, file)) : failure(columns.error());
    }
    case FileFormat::netcdf:
      return failure(FaultKind::bad_file, file,
                     "HDF5 or NetCDF: no map can be guessed; write one with format = \"netcdf\" in [file]");
    case FileFormat::text: break;
  }
  auto sample = sample_table(std::move(bytes));
  if (!sample) return failure(sample.error());
  return table_map(*sample, file);
}

}  // namespace

Result<FileFormat> detect_format(Bytes& bytes) {
  constexpr std::size_t kExaminedBytes = 1024;
  const auto beginning = bytes.peek(kExaminedBytes);
  if (!beginning) return failure(beginning.error());
  if (const auto known = conversion_advice(*beginning); !known.empty())
    return failure(FaultKind::bad_file, bytes.name(), known);
  if (is_ulog(*beginning)) return FileFormat::ulog;
  if (is_dataflash(*beginning)) return FileFormat::dataflash;
  return is_netcdf(*beginning) ? FileFormat::netcdf : FileFormat::text;
}

Result<std::string> guess_map(const std::string& path) {
  auto bytes = Bytes::open(path);
  if (!bytes) return failure(bytes.error());
  if (const auto format = detect_format(*bytes); format && *format == FileFormat::netcdf) {
    if (auto map = own_netcdf_map(path); !map.empty()) return map;
    return failure(
        FaultKind::bad_file, path,
        fmt::format("HDF5 or NetCDF: no map can be guessed; write one with format = \"netcdf\" in [file] and "
                    "a time column ({})",
                    list_netcdf_variables(path)));
  }
  return guess(std::move(*bytes));
}

Result<std::string> guess_map_from_bytes(std::string_view bytes, const std::string& name) {
  return guess(Bytes(bytes, name));
}

}  // namespace gyrotherm::exchange
