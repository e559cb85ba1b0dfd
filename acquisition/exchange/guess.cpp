// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/guess.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>
#include <vector>

#include "acquisition/exchange/civil_time.hpp"
#include "acquisition/exchange/column_names.hpp"
#include "acquisition/exchange/dataflash.hpp"
#include "acquisition/exchange/import_map.hpp"
#include "acquisition/exchange/text_lines.hpp"
#include "acquisition/exchange/ulog.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/schema.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

constexpr std::size_t kRowsToLookAt = 400;

std::string toml_text(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : plain(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

/// The first lines of a table, cut into fields.
struct Sample {
  std::string comment;
  char separator = ',';
  bool header = true;
  char decimal = '.';
  std::vector<std::string> names{};              ///< of the columns, or their numbers
  std::size_t skip{};                            ///< lines behind the header that are no rows
  std::vector<std::vector<std::string>> rows{};  ///< fields
  std::vector<std::string> missing{};            ///< fields among numbers that are none
};

std::vector<std::string> fields_of(const std::string& line, char separator) {
  std::vector<record::Field> fields;
  std::vector<std::string> texts;
  if (!record::cut(line, separator, fields)) return texts;
  for (const auto& field : fields) texts.push_back(in_utf8(trimmed(record::unquoted(field))));
  return texts;
}

struct Line {
  std::size_t number{};  ///< among all but comments
  std::string text;
};

/// The separator that cuts most lines into as many fields as the first row has; a comma may be a decimal one.
char separator_of(const std::vector<Line>& lines) {
  constexpr std::array<char, 4> kInOrder{'\t', ';', ',', ' '};
  char best = ',';
  std::size_t most = 0;
  for (const char separator : kInOrder) {
    const std::size_t width = fields_of(lines.back().text, separator).size();
    const auto alike = static_cast<std::size_t>(std::ranges::count_if(
        lines, [&](const Line& line) { return fields_of(line.text, separator).size() == width; }));
    if (width < 2 || alike <= most) continue;
    best = separator;
    most = alike;
  }
  return best;
}

std::optional<double> number_of(std::string text, char decimal) {
  if (decimal == ',') {
    if (text.find('.') != std::string::npos) return std::nullopt;
    std::ranges::replace(text, ',', '.');
  }
  return record::number_in(text);
}

/// Numbers with a decimal comma, less those with a point.
char decimal_of(const std::vector<std::vector<std::string>>& rows, char separator) {
  if (separator == ',') return '.';
  std::int64_t commas = 0;
  for (const auto& row : rows)
    for (const auto& field : row) {
      if (field.find(',') != std::string::npos && number_of(field, ',')) ++commas;
      if (field.find('.') != std::string::npos && number_of(field, '.')) --commas;
    }
  return commas > 0 ? ',' : '.';
}

/// The numbers of a column; fewer than half of its fields: none.
std::vector<double> numbers_of(const Sample& sample, std::size_t column) {
  std::vector<double> numbers;
  for (const auto& row : sample.rows)
    if (const auto number = number_of(row[column], sample.decimal)) numbers.push_back(*number);
  return 2 * numbers.size() >= sample.rows.size() ? numbers : std::vector<double>{};
}

void find_missing(Sample& sample) {
  constexpr std::size_t kMost = 8;
  std::set<std::string> found;
  for (std::size_t column = 0; column < sample.names.size(); ++column) {
    if (numbers_of(sample, column).empty()) continue;
    for (const auto& row : sample.rows)
      if (!number_of(row[column], sample.decimal) && found.size() < kMost) found.insert(row[column]);
  }
  sample.missing.assign(found.begin(), found.end());
}

Result<std::vector<Line>> first_lines(Bytes bytes) {
  auto lines = TextLines::open(std::move(bytes), "");
  if (!lines) return failure(lines.error());
  std::vector<Line> first;
  while (first.size() < kRowsToLookAt) {
    const auto next = lines->next();
    if (!next) return failure(next.error());
    if (!*next) break;
    first.push_back({lines->number(), std::string(lines->line())});
  }
  return first;
}

/// Takes lines that begin like a comment off the lines.
std::string take_comments(std::vector<Line>& lines) {
  std::string comment;
  for (const char* mark : {"#", "%", "//"})
    if (comment.empty() && lines.front().text.starts_with(mark)) comment = mark;
  if (comment.empty()) return comment;
  std::size_t comments = 0;
  for (Line& line : lines) {
    if (line.text.starts_with(comment)) ++comments;
    line.number -= comments;
  }
  std::erase_if(lines, [&](const Line& line) { return line.text.starts_with(comment); });
  return comment;
}

/// A header may have a row of units under it: a row without a number where the next one has some.
bool begins_with_units(const Sample& sample) {
  const auto has_number = [&](const std::vector<std::string>& row) {
    return std::ranges::any_of(
        row, [&](const std::string& field) { return number_of(field, sample.decimal) || parse_civil_time(field); });
  };
  return sample.header && sample.rows.size() > 1 && !has_number(sample.rows[0]) && has_number(sample.rows[1]);
}

Result<Sample> sample_of(Bytes bytes) {
  const std::string file = bytes.name();
  auto lines = first_lines(std::move(bytes));
  if (!lines) return failure(lines.error());
  const auto no_table = [&] {
    return failure(FaultKind::bad_file, file, "no text table of two columns or more, and no log that is known");
  };
  if (lines->empty()) return no_table();
  Sample sample{.comment = take_comments(*lines)};
  if (lines->empty()) return no_table();
  sample.separator = separator_of(*lines);
  sample.names = fields_of(lines->front().text, sample.separator);
  sample.header = std::ranges::none_of(sample.names, [](const std::string& name) {
    return number_of(name, '.') || number_of(name, ',') || parse_civil_time(name);
  });
  std::size_t first = 0;
  for (std::size_t i = sample.header ? 1 : 0; i < lines->size(); ++i)
    if (auto row = fields_of((*lines)[i].text, sample.separator); row.size() == sample.names.size()) {
      if (sample.rows.empty()) first = (*lines)[i].number;
      sample.rows.push_back(std::move(row));
    }
  if (sample.names.size() < 2 || sample.rows.empty()) return no_table();
  for (std::size_t i = 0; !sample.header && i < sample.names.size(); ++i) sample.names[i] = std::to_string(i + 1);
  sample.decimal = decimal_of(sample.rows, sample.separator);
  if (begins_with_units(sample)) {
    sample.skip = first - lines->front().number;
    sample.rows.erase(sample.rows.begin());
  }
  find_missing(sample);
  return sample;
}

/// What a column of times is taken for.
struct TimeGuess {
  std::optional<std::size_t> column{};
  std::string unit{};
  std::string why{};  ///< that unit
  bool since_1970 = false;
  bool has_zone = true;
  bool in_order = true;
  std::optional<double> step_s{};  ///< usual
};

bool is_civil(const Sample& sample, std::size_t column) {
  return std::ranges::all_of(sample.rows, [&](const auto& row) { return parse_civil_time(row[column]).has_value(); });
}

double seconds_in(std::string_view unit) {
  if (unit == "ns") return 1e-9;
  if (unit == "us") return 1e-6;
  return unit == "ms" ? 1e-3 : 1;
}

bool is_unit_of_time(std::string_view unit) { return unit == "s" || unit == "ms" || unit == "us" || unit == "ns"; }

/// Numbers that are times of this century since 1970 show their unit by their size.
std::string unit_since_1970(double number) {
  constexpr double kFirst = 9e8, kLast = 4e9;  // seconds
  for (const char* unit : {"s", "ms", "us", "ns"})
    if (number * seconds_in(unit) >= kFirst && number * seconds_in(unit) < kLast) return unit;
  return "";
}

/// Rows come more often than every five seconds, as a rule.
std::string unit_by_step(double step) {
  constexpr double kSlowest = 5;
  for (const char* unit : {"s", "ms", "us"})
    if (step * seconds_in(unit) <= kSlowest) return unit;
  return "ns";
}

double usual_step(std::vector<double> times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  if (steps.empty()) return 0;
  std::ranges::nth_element(steps, steps.begin() + std::ssize(steps) / 2);
  return steps[steps.size() / 2];
}

bool increases(const std::vector<double>& times) {
  return std::ranges::adjacent_find(times, std::greater_equal<>()) == times.end();
}

/// The unit in the name counts; numbers that could be times since 1970 are so if it agrees, or where there is none if a
/// row would come every ten minutes at least, which tells a clock from a counter of microseconds.
TimeGuess guess_numbers_of_time(const Sample& sample, std::size_t column) {
  constexpr double kSlowestOfAClock = 600;
  const auto times = numbers_of(sample, column);
  const double step = usual_step(times);
  const std::string named = sample.header ? time_unit_in(sample.names[column]) : "";
  const std::string since = unit_since_1970(times.front());
  TimeGuess guess{.column = column, .unit = named, .why = "as its name says", .in_order = increases(times)};
  if (is_unit_of_time(named)) {
    guess.since_1970 = named == since;
  } else {
    guess.since_1970 = !since.empty() && step * seconds_in(since) <= kSlowestOfAClock;
    guess.unit = guess.since_1970 ? since : unit_by_step(step);
    guess.why = guess.since_1970 ? "a guess by the size of its numbers" : "a guess by its steps";
    if (!named.empty()) guess.why += fmt::format(", a map knows no {}", toml_text(named));
  }
  if (step > 0) guess.step_s = step * seconds_in(guess.unit);
  return guess;
}

TimeGuess guess_civil_time(const Sample& sample, std::size_t column) {
  TimeGuess guess{.column = column, .unit = "iso"};
  std::vector<double> times;
  for (const auto& row : sample.rows) {
    const auto time = *parse_civil_time(row[column]);
    guess.has_zone = guess.has_zone && time.zone.has_value();
    times.push_back(to_seconds(time.reading - time.zone.value_or(Duration{})));
  }
  guess.in_order = increases(times);
  if (const double step = usual_step(times); step > 0) guess.step_s = step;
  return guess;
}

/// A column whose usual row is not after the one before, as where dates stand apart from the time of day, is none of
/// times.
bool goes_on(const Sample& sample, const TimeGuess& guess) {
  return sample.rows.size() < 2 || guess.step_s.has_value();
}

TimeGuess guess_time(const Sample& sample) {
  for (std::size_t i = 0; i < sample.names.size(); ++i)
    if (is_civil(sample, i))
      if (auto guess = guess_civil_time(sample, i); goes_on(sample, guess)) return guess;
  for (std::size_t i = 0; sample.header && i < sample.names.size(); ++i)
    if (is_time_name(sample.names[i]) && !numbers_of(sample, i).empty())
      if (auto guess = guess_numbers_of_time(sample, i); goes_on(sample, guess)) return guess;
  for (std::size_t i = 0; i < sample.names.size(); ++i)
    if (const auto numbers = numbers_of(sample, i); numbers.size() > 2 && increases(numbers))
      return guess_numbers_of_time(sample, i);
  return {};
}

/// Columns as a map calls them: by name, or by number.
std::string reference(const std::string& name, bool header) { return header ? toml_text(name) : name; }

std::string file_section(const Sample& sample) {
  std::string text =
      fmt::format("[file]\nseparator = {}\n", sample.separator == '\t' ? "\"\\t\"" : toml_text({&sample.separator, 1}));
  if (sample.decimal == ',') text += "decimal = \",\"\n";
  if (!sample.comment.empty()) text += fmt::format("comment = {}\n", toml_text(sample.comment));
  if (!sample.header) text += "header = false\n";
  if (sample.skip > 0) text += fmt::format("skip = {}        # the row of units under the header\n", sample.skip);
  if (sample.missing.empty()) return text;
  text += "missing = [";
  for (const auto& field : sample.missing)
    text += fmt::format("{}{}", &field == &sample.missing.front() ? "" : ", ", toml_text(field));
  return text + "]        # fields among numbers that are none\n";
}

std::string time_section(const Sample& sample, const TimeGuess& time) {
  if (!time.column)
    return "[time]\ninterval = \"1 s\"        # no column of times that go on was found: how long does a row last?\n";
  std::string text =
      fmt::format("[time]\ncolumn = {}\nunit = \"{}\"{}\n", reference(sample.names[*time.column], sample.header),
                  time.unit, time.why.empty() ? "" : "        # " + time.why);
  if (time.since_1970) text += "since = \"1970-01-01T00:00:00Z\"        # by the size of its numbers: is it UTC?\n";
  if (!time.has_zone) text += "zone = \"Z\"        # the times name none: is it UTC?\n";
  if (!time.in_order)
    text += "out_of_order = \"skip\"        # the time goes back in the first rows: such rows are left out\n";
  constexpr double kFastestKept = 0.5;
  if (time.step_s && *time.step_s < kFastestKept)
    text += fmt::format("every = \"1 s\"        # rows come every {:.3g} s: means of a second\n", *time.step_s);
  return text;
}

/// What makes °C of a thermometer's column: of kelvins an offset, of what the name does not say, or says in a unit that
/// is not known, a comment. Logs have °C (`usual`).
std::string celsius_lines(const std::string& name, std::string_view usual) {
  std::string unit = temperature_unit_in(name);
  if (unit.empty()) unit = usual;
  if (unit == "°C") return "\n";
  if (unit == "K") return "\noffset = -273.15        # of kelvins\n";
  const auto said =
      unit.empty() ? "a guess that it is in °C" : fmt::format("a guess, \"{}\" is not known", plain(unit));
  return fmt::format("        # {}: °C = number × scale + offset\n", said);
}

std::string thermometer_sections(const std::vector<std::string>& names, const std::vector<std::size_t>& columns,
                                 std::string_view usual_unit) {
  std::string text;
  auto taken = record::names_of_every_record();
  taken.insert({"pulses", "interval_ns"});  // of a gyro without a name
  for (const std::size_t column : columns) {
    std::string name = channel_name_of(names[column]);
    while (name.empty() || !taken.insert(in_lower_case(name)).second) name += "T";
    text += fmt::format("\n[[thermometer]]\nname = {}\ncolumn = {}{}", toml_text(name), toml_text(names[column]),
                        celsius_lines(names[column], usual_unit));
  }
  return text;
}

/// The lines of one axis: which column, and what a unit of it is.
std::string axis_lines(const std::string& name, bool header, std::optional<double> scale) {
  return fmt::format("column = {}\nkind = \"rate\"\nscale = {}        # °/h per unit of the column{}\n",
                     reference(name, header), scale.value_or(1), scale ? "" : ": a guess, correct it");
}

std::string gyro_section(const std::vector<std::string>& names, const std::vector<std::size_t>& columns, bool header,
                         std::optional<double> usual_scale) {
  const auto scale_of = [&](const std::string& name) {
    const auto scale = degrees_per_hour_in(name);
    return scale ? scale : usual_scale;
  };
  if (columns.empty())
    return "\n[gyro]\ncolumn = \"\"        # which column is the gyro's?\nkind = \"rate\"\nscale = 1        # °/h per "
           "unit "
           "of the column\n";
  if (columns.size() == 1)
    return "\n[gyro]\n" + axis_lines(names[columns.front()], header, scale_of(names[columns.front()]));
  std::string text = "\n[[gyro]]\nname = \"imu\"\n";
  std::set<std::string> taken;
  for (const std::size_t column : columns) {
    std::string axis = axis_in(names[column]);
    while (axis.empty() || !taken.insert(axis).second) axis += std::to_string(taken.size() + 1);
    text += fmt::format("\n[[gyro.axis]]\nname = \"{}\"\n", axis) +
            axis_lines(names[column], header, scale_of(names[column]));
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

std::vector<std::size_t> temperature_columns(const std::vector<std::string>& names,
                                             const std::vector<std::size_t>& others) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (is_temperature_name(names[i]) && std::ranges::find(others, i) == others.end()) found.push_back(i);
  return found;
}

std::string table_map(const Sample& sample, const std::string& file) {
  const TimeGuess time = guess_time(sample);
  std::vector<std::size_t> gyros;
  if (sample.header) gyros = gyro_columns(sample.names);
  std::erase_if(gyros, [&](std::size_t column) { return column == time.column || numbers_of(sample, column).empty(); });
  auto others = gyros;
  if (time.column) others.push_back(*time.column);
  std::vector<std::size_t> thermometers;
  if (sample.header) thermometers = temperature_columns(sample.names, others);
  if (!sample.header) gyros.assign(1, sample.names.size() - 1);
  return head_of(file, sample.names) + file_section(sample) + "\n" + time_section(sample, time) +
         thermometer_sections(sample.names, thermometers, "") + gyro_section(sample.names, gyros, sample.header, {});
}

std::string log_map(const std::vector<LogColumn>& columns, FileFormat format, const std::string& file) {
  constexpr double kRadianPerSecond = 206264.80624709636;  // in °/h: both autopilots log radians
  std::vector<std::string> names;
  for (const LogColumn& column : columns)
    names.push_back(name_of_series(column.message, column.instance) + "." + column.field);
  const auto gyros = gyro_columns(names);
  return head_of(file, names) +
         fmt::format(
             "[file]\nformat = \"{}\"\n\n[time]\nevery = \"1 s\"        # messages are put together: means of a "
             "second\n",
             name(format)) +
         thermometer_sections(names, temperature_columns(names, gyros), "°C") +
         gyro_section(names, gyros, true, kRadianPerSecond);
}

Result<std::string> guess(Bytes bytes) {
  constexpr std::size_t kBeginning = 16;
  const std::string file = bytes.name();
  const auto beginning = bytes.ahead(kBeginning);
  if (!beginning) return failure(beginning.error());
  const bool is_px4 = is_ulog(*beginning);
  if (is_px4 || is_dataflash(*beginning)) {
    const auto columns = is_px4 ? columns_of_ulog(std::move(bytes)) : columns_of_dataflash(std::move(bytes));
    if (!columns) return failure(columns.error());
    return log_map(*columns, is_px4 ? FileFormat::ulog : FileFormat::dataflash, file);
  }
  auto sample = sample_of(std::move(bytes));
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
