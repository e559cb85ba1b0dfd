// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/guess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <vector>

#include "acquisition/exchange/column_names.hpp"
#include "acquisition/exchange/dataflash.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/known_formats.hpp"
#include "acquisition/exchange/log_guess.hpp"
#include "acquisition/exchange/netcdf_table.hpp"
#include "acquisition/exchange/table_sample.hpp"
#include "acquisition/exchange/time_guess.hpp"
#include "acquisition/exchange/ulog.hpp"
#include "acquisition/record/schema.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

using Columns = std::vector<std::size_t>;

std::string file_section(const TableSample& sample) {
  const auto& style = sample.style;
  std::string text =
      fmt::format("[file]\nseparator = {}\n", sample.separator == '\t' ? "\"\\t\"" : toml_text({&sample.separator, 1}));
  if (style.decimal == ',') text += "decimal = \",\"\n";
  if (sample.is_decimal_doubtful)
    text +=
        "decimal = \"?\"        # are \"1,234\" a thousand and some, or one and a part? Say thousands = \",\" or "
        "decimal = \",\"\n";
  if (style.thousands != 0)
    text += fmt::format("thousands = {}        # parts the thousands of a number\n", toml_text({&style.thousands, 1}));
  if (!style.units.empty()) {
    text += "cell_units = [";
    for (const auto& unit : style.units) text += (&unit == &style.units.front() ? "" : ", ") + toml_text(unit);
    text += "]        # stand behind numbers\n";
  }
  if (!sample.comment.empty()) text += fmt::format("comment = {}\n", toml_text(sample.comment));
  if (sample.preamble > 0) text += fmt::format("preamble = {}        # lines before the header\n", sample.preamble);
  if (!sample.header) text += "header = false\n";
  if (sample.skip > 0)
    text += fmt::format("skip = {}        # {}\n", sample.skip,
                        sample.header ? "lines under the header that are no rows" : "lines before the first row");
  if (sample.damaged > 0)
    text += fmt::format(
        "damaged = \"skip\"        # {} of the lines cannot be read, the first is line {}: they are left "
        "out and counted\n",
        sample.damaged, sample.first_damaged);
  if (sample.missing.empty()) return text;
  text += "missing = [";
  for (const auto& field : sample.missing)
    text += fmt::format("{}{}", &field == &sample.missing.front() ? "" : ", ", toml_text(field));
  return text + "]        # fields among numbers that are none\n";
}

/// Returns the lines that convert a thermometer's column to °C: for a known unit its scale, for what the name does not
/// say, or says in a unit that is not known, a comment. Logs have °C (`usual`).
std::string celsius_lines(const std::string& name, std::string_view usual) {
  std::string unit = temperature_unit_in(name);
  if (unit.empty()) unit = usual;
  if (unit == "°C") return "\n";
  if (unit == "K") return "\noffset = -273.15        # of kelvins\n";
  if (const auto scale = unit.empty() ? std::nullopt : celsius_scale_of(unit)) {
    std::string text = fmt::format("\nscale = {:.15g}        # of {}\n", scale->scale, plain(unit));
    if (scale->offset != 0) text += fmt::format("offset = {:.15g}\n", scale->offset);
    return text;
  }
  const auto said =
      unit.empty() ? "a guess that it is in °C" : fmt::format("a guess, \"{}\" is not known", plain(unit));
  return fmt::format("        # {}: °C = number × scale + offset\n", said);
}

/// Names of thermometers, of which no two are alike.
class ThermometerNames {
 public:
  ThermometerNames() : taken_(record::names_of_every_record()) {
    taken_.insert({"pulses", "interval_ns"});  // of a gyro without a name
  }
  std::string next(const std::string& column) {
    std::string name = channel_name_of(column);
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
    const auto name = sample.name_of(column);
    text += fmt::format("\n[[thermometer]]\nname = {}\n{}{}", toml_text(names.next(name)), reference(sample, column),
                        celsius_lines(name, ""));
  }
  return text;
}

/// The lines of one axis: which column, and what a unit of it is.
std::string axis_lines(const std::string& column, bool is_increment, std::optional<double> scale) {
  const char* per = is_increment ? "arcsec" : "°/h";
  return fmt::format("{}\nkind = \"{}\"\nscale = {:.15g}        # {} per unit of the column{}\n", column,
                     is_increment ? "increment" : "rate", scale.value_or(1), per, scale ? "" : ": a guess, correct it");
}

std::string gyro_section(const TableSample& sample, const Columns& columns) {
  if (columns.empty())
    return "\n[gyro]\ncolumn = \"\"        # which column is the gyro's?\nkind = \"rate\"\nscale = 1        # °/h per "
           "unit of the column\n";
  const bool are_increments = sample.header && std::ranges::all_of(columns, [&](std::size_t column) {
                                return is_increment_name(sample.name_of(column));
                              });
  const auto lines = [&](std::size_t column) {
    const auto name = sample.name_of(column);
    return axis_lines(reference(sample, column), are_increments,
                      are_increments ? std::nullopt : degrees_per_hour_in(name));
  };
  if (columns.size() == 1) return "\n[gyro]\n" + lines(columns.front());
  std::string text = "\n[[gyro]]\nname = \"imu\"\n";
  std::set<std::string> taken;
  for (const std::size_t column : columns) {
    std::string axis = axis_in(sample.name_of(column));
    while (axis.empty() || !taken.insert(axis).second) axis += std::to_string(taken.size() + 1);
    text += fmt::format("\n[[gyro.axis]]\nname = \"{}\"\n", axis) + lines(column);
  }
  return text;
}

std::string head_of(const std::string& file, const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 400, kWidest = 100;
  const auto name = plain(std::filesystem::path(file).filename().string());
  std::string text = fmt::format("# A first map of {}, guessed: look at every line. Its columns:\n", name), line;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i) {
    if (line.size() > kWidest) {
      text += "#  " + line + "\n";
      line.clear();
    }
    line += " " + toml_text(names[i]);
  }
  text += "#  " + line + (names.size() > kMost ? " …\n" : "\n");
  return text + fmt::format("schema = \"{}\"\nname = {}\n\n", kImportSchema, toml_text(name));
}

bool is_in(const Columns& columns, std::size_t column) { return std::ranges::find(columns, column) != columns.end(); }

std::string table_map(const TableSample& sample, const std::string& file) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < sample.names.size(); ++i) names.push_back(sample.name_of(i));
  const bool has_names = std::ranges::any_of(sample.names, [](const std::string& name) { return !name.empty(); });
  const auto has_numbers = [&](std::size_t column) { return !sample.numbers_of(column).empty(); };
  Columns gyros = has_names ? gyro_columns(names) : Columns{};
  std::erase_if(gyros, [&](std::size_t column) { return !has_numbers(column) || is_time_name(names[column]); });
  Columns thermometers;
  for (std::size_t i = 0; has_names && i < names.size(); ++i)
    if (is_temperature_name(names[i]) && !is_in(gyros, i) && has_numbers(i)) thermometers.push_back(i);
  const TimeGuess time = guess_time(sample, thermometers);
  const auto is_of_time = [&](std::size_t column) { return is_in(time.columns, column); };
  std::erase_if(gyros, is_of_time);
  std::erase_if(thermometers, is_of_time);
  if (!has_names) gyros.assign(1, names.size() - 1);
  return head_of(file, names) + file_section(sample) + "\n" + time.text + thermometer_sections(sample, thermometers) +
         gyro_section(sample, gyros);
}

std::string log_map(const std::vector<LogColumn>& columns, FileFormat format, const std::string& file) {
  constexpr double kRadianPerSecond = 206264.80624709636;  // in °/h: both autopilots log radians
  std::vector<std::string> names;
  for (const LogColumn& column : columns)
    names.push_back(name_of_series(column.message, column.instance) + "." + column.field);
  const LogGuess guess = guess_log(columns);
  std::string text =
      head_of(file, names) + fmt::format(
                                 "[file]\nformat = \"{}\"\n\n[time]\nevery = \"1 s\"        # messages are put "
                                 "together: means of a second\n",
                                 name(format));
  ThermometerNames thermometers;
  std::vector<std::string> others;
  const auto add_thermometer = [&](const std::string& column) {
    auto plain_name = column;  // "sensor_gyro1.temperature"
    std::erase_if(plain_name, [](char c) { return c == '[' || c == ']'; });
    const auto called = thermometers.next(plain_name);
    text += fmt::format("\n[[thermometer]]\nname = {}\ncolumn = {}\n", toml_text(called), toml_text(column));
    return toml_text(called);
  };
  for (const auto& column : guess.others) others.push_back(add_thermometer(column));
  std::vector<std::string> own;
  for (const LoggedGyro& gyro : guess.gyros)
    own.push_back(gyro.temperature.empty() ? "" : add_thermometer(gyro.temperature));
  if (guess.gyros.empty())
    return text +
           "\n[gyro]\ncolumn = \"\"        # which column is the gyro's?\nkind = \"rate\"\nscale = 1        # °/h "
           "per unit of the column\n";
  for (std::size_t i = 0; i < guess.gyros.size(); ++i) {
    auto near = others;
    if (!own[i].empty()) near.insert(near.begin(), own[i]);
    text += fmt::format("\n[[gyro]]\nname = \"{}\"\n", guess.gyros[i].name);
    if (!near.empty()) text += fmt::format("thermometers = [{}]\n", fmt::join(near, ", "));
    std::set<std::string> taken;
    for (const auto& column : guess.gyros[i].axes) {
      std::string axis = axis_in(column);
      while (axis.empty() || !taken.insert(axis).second) axis += std::to_string(taken.size() + 1);
      text +=
          fmt::format("\n[[gyro.axis]]\nname = \"{}\"\n", axis) +
          axis_lines("column = " + toml_text(column), false, degrees_per_hour_in(column).value_or(kRadianPerSecond));
    }
  }
  return text;
}

Result<std::string> guess(Bytes bytes) {
  const std::string file = bytes.name();
  const auto beginning = bytes.ahead(kBeginningOfFormats);
  if (!beginning) return failure(beginning.error());
  if (const auto known = way_out_of_format(*beginning); !known.empty())
    return failure(FaultKind::bad_file, file, known);
  const bool is_px4 = is_ulog(*beginning);
  if (is_px4 || is_dataflash(*beginning)) {
    const auto columns = is_px4 ? columns_of_ulog(std::move(bytes)) : columns_of_dataflash(std::move(bytes));
    if (!columns) return failure(columns.error());
    return log_map(*columns, is_px4 ? FileFormat::ulog : FileFormat::dataflash, file);
  }
  if (is_netcdf(*beginning))
    return failure(FaultKind::bad_file, file,
                   "HDF5 or NetCDF, of which no map is guessed; write one with format = \"netcdf\" in [file]");
  auto sample = sample_table(std::move(bytes));
  if (!sample) return failure(sample.error());
  return table_map(*sample, file);
}

}  // namespace

Result<std::string> guess_map(const std::string& path) {
  auto bytes = Bytes::open(path);
  if (!bytes) return failure(bytes.error());
  return guess(std::move(*bytes));
}

Result<std::string> guess_map_of(std::string_view bytes, const std::string& name) { return guess(Bytes(bytes, name)); }

}  // namespace gyrotherm::exchange
