// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/exchange/row_clock.hpp"
#include "acquisition/exchange/text_lines.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/row.hpp"
#include "core/count_text.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

using record::Field, record::assign_result, record::kMissing;

constexpr std::string_view kAllDigits = "0123456789", kNoBreakSpace = "\xC2\xA0", kNarrowSpace = "\xE2\x80\xAF";

bool is_plain(std::string_view text, const NumberStyle& style) {
  return style.decimal == '.' && style.thousands == 0 && style.units.empty() && !text.empty() &&
         static_cast<unsigned char>(text.front()) < 0x80;
}

std::string_view strip_unit(std::string_view text, const std::vector<std::string>& units) {
  for (const std::string& unit : units) {
    if (unit.empty() || text.size() <= unit.size() || !text.ends_with(unit)) continue;
    const auto number = trimmed(text.substr(0, text.size() - unit.size()));
    constexpr std::string_view kLastCharacters = "0123456789.,";
    if (!number.empty() && kLastCharacters.find(number.back()) != std::string_view::npos) return number;
  }
  return text;
}

bool is_empty(const Field& field) { return trimmed(field.text).empty(); }

/// Collects the lines that could not be read.
class DamagedLines {
 public:
  void add(const Fault& fault) {
    if (count_++ == 0) first_ = fault;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const Fault& first() const { return first_; }
  [[nodiscard]] std::string describe() const {
    return fmt::format("{} line{} cannot be read and {} left out; the first: {}", count_, count_ > 1 ? "s" : "",
                       count_ > 1 ? "were" : "was", text(first_));
  }

 private:
  std::size_t count_{};
  Fault first_{};
};

/// The indices of the map's columns among the fields of a row.
struct TableLayout {
  /// The number of fields of the header or of the first row.
  std::size_t width{};
  std::optional<std::size_t> time{}, clock{}, week{};
  std::vector<std::size_t> columns{};

  /// Returns whether a row with this number of fields has all columns of the map.
  [[nodiscard]] bool is_within(std::size_t fields) const {
    const auto reaches = [&](std::optional<std::size_t> index) { return !index || *index < fields; };
    return reaches(time) && reaches(clock) && reaches(week) && std::ranges::all_of(columns, reaches);
  }
  [[nodiscard]] bool has(std::size_t index) const {
    return index == time || index == clock || index == week || std::ranges::find(columns, index) != columns.end();
  }
};

/// Reads a table sequentially. Stops at the first fault unless the map skips damaged lines.
class TextTable {
 public:
  TextTable(TextLines lines, const ImportMap& map, const TakeRow& take)
      : lines_(std::move(lines)),
        map_(map),
        take_(take),
        columns_(map.columns()),
        style_{map.decimal, map.thousands, map.cell_units},
        clock_(map),
        numbers_(columns_.size()),
        missing_(columns_.size()) {
    for (const std::string& missing : map.missing) {
      missing_texts_.emplace_back(trimmed(missing));
      if (const auto number = record::number_in(style_.normalise(missing_texts_.back(), changed_)))
        missing_numbers_.push_back(*number);
    }
  }

  Result<Findings> read() {
    if (auto begun = begin(); !begun) return failure(begun.error());
    while (true) {
      const auto line = lines_.next();
      if (line && !*line) break;
      auto row = !line                   ? Result<void>(failure(line.error()))
                 : is_between_segments() ? skip_segment_header()
                                         : read_row();
      if (row) continue;
      if (is_take_fault_ || !map_.leaves_out_damaged || row.error().kind != FaultKind::bad_file)
        return failure(std::move(row.error()));
      damaged_.add(row.error());
      if (auto passed = lines_.recover(); !passed) return failure(passed.error());
    }
    return finish();
  }

 private:
  Fault fault_at(std::size_t column, std::string what) const { return lines_.fault_at(column, std::move(what)); }

  Result<void> expect(const Result<bool>& line, const char* otherwise) const {
    if (!line) return failure(line.error());
    return *line ? Result<void>{} : failure(fault_at(1, otherwise));
  }

  Result<void> begin() {
    for (std::size_t i = 0; i < map_.preamble; ++i)
      if (auto line = expect(lines_.skip_any_line(), "the file ends within its preamble"); !line) return line;
    if (map_.header)
      if (auto header = read_header(); !header) return header;
    for (std::size_t i = 0; i < map_.skip; ++i)
      if (auto line = expect(lines_.skip_line(), "the file ends within the lines to skip"); !line) return line;
    return {};
  }

  /// Returns whether the line begins another header, or has only separators in a file with several headers.
  bool is_between_segments() const {
    if (map_.segment_begin.empty()) return false;
    const auto line = lines_.line();
    return line.starts_with(map_.segment_begin) || line.find_first_not_of(" \t,;") == std::string_view::npos;
  }

  /// Skips a header between rows, and its line of names, which must be that of the first header.
  Result<void> skip_segment_header() {
    if (!lines_.line().starts_with(map_.segment_begin)) return {};
    constexpr const char* kNoEnd = "the file ends within a header, expected its last line and the names of columns";
    while (!lines_.line().starts_with(map_.segment_end))
      if (auto line = expect(lines_.next(), kNoEnd); !line) return line;
    if (!map_.header) return {};
    if (auto line = expect(lines_.next(), kNoEnd); !line) return line;
    if (auto parted = split_line(); !parted) return parted;
    std::vector<std::string> names;
    for (const Field& field : fields_) names.push_back(in_utf8(trimmed(record::unquote(field))));
    if (names == header_) return {};
    return failure(
        fault_at(1, "the columns of this segment differ from those of the first; expected one file for each"));
  }

  Result<Findings> finish() {
    if (rows_ == 0 && damaged_.count() > 0) return failure(damaged_.first());
    if (rows_ == 0) return failure(fault_at(1, "the file ends, expected at least one row"));
    if (damaged_.count() > static_cast<std::size_t>(rows_)) {
      Fault fault = damaged_.first();
      fault.what += fmt::format("; {} lines cannot be read, more than the {} rows that can", damaged_.count(), rows_);
      return failure(std::move(fault));
    }
    Findings findings{.missing = std::move(missing_), .lines_left_out = damaged_.count()};
    if (damaged_.count() > 0) findings.notes.push_back(damaged_.describe());
    if (!lines_.has_end()) findings.notes.push_back(torn_ ? torn_note() : open_note());
    other_clocks_.report(findings);
    return findings;
  }

  std::string open_note() const {
    return fmt::format("the last line, {}, has no line end: its last value may be cut off", lines_.number());
  }
  std::string torn_note() const {
    return fmt::format(
        "the last line, {}, was left out: it has no line end, and its last number has fewer decimals than all before",
        lines_.number());
  }

  Result<void> split_line() {
    auto parted = record::split_line(lines_.line(), map_.separator, fields_);
    if (!parted) return failure(fault_at(parted.error().column, std::move(parted.error().what)));
    return {};
  }

  Result<void> read_header() {
    if (auto line = expect(lines_.next(), "the file ends, expected a header"); !line) return line;
    if (auto parted = split_line(); !parted) return parted;
    for (const Field& field : fields_) header_.push_back(in_utf8(trimmed(record::unquote(field))));
    is_layout_final_ = true;
    return assign_result(layout_, locate_columns());
  }

  /// Returns whether the map refers to a column by its number.
  bool is_numbered(const ColumnName& column) const {
    return !map_.header || (column.name.empty() && column.number > 0);
  }

  /// Returns the index of a column among the fields of the present line. Returns nothing if the line does not have it.
  Result<std::optional<std::size_t>> find_column(const ColumnName& column) const {
    if (is_numbered(column))
      return column.number > 0 && column.number <= fields_.size() ? std::optional(column.number - 1) : std::nullopt;
    const std::string wanted(trimmed(column.name));
    const auto found = std::ranges::find(header_, wanted);
    if (found == header_.end()) return std::nullopt;
    const auto index = static_cast<std::size_t>(found - header_.begin());
    if (const auto again = std::find(found + 1, header_.end(), wanted); again != header_.end())
      return failure(fault_at(fields_[static_cast<std::size_t>(again - header_.begin())].column,
                              fmt::format("a second column \"{}\", expected one, or column_number = {} in the map",
                                          column.name, index + 1)));
    return index;
  }

  /// Finds the columns of the map in the header or, without a header, among the fields of the present line. Fails if
  /// any of them is missing.
  Result<TableLayout> locate_columns() const {
    TableLayout layout{.width = fields_.size()};
    std::vector<ColumnName> missing;
    const auto locate = [&](const ColumnName& column, std::optional<std::size_t>& index) {
      auto found = assign_result(index, find_column(column));
      if (found && !index) missing.push_back(column);
      return found;
    };
    for (const auto& [column, index] :
         {std::pair(&map_.time, &layout.time), {&map_.clock, &layout.clock}, {&map_.week, &layout.week}})
      if (*column)
        if (auto found = locate(**column, *index); !found) return failure(found.error());
    for (const ColumnName& column : columns_) {
      std::optional<std::size_t> index;
      if (auto found = locate(column, index); !found) return failure(found.error());
      layout.columns.push_back(index.value_or(0));
    }
    if (missing.empty()) return layout;
    return failure(fault_at(1, describe_missing(missing) + suggest_separator()));
  }

  /// Describes the missing columns with a name, and the highest missing number.
  std::string describe_missing(const std::vector<ColumnName>& missing) const {
    std::vector<std::string> names;
    std::size_t highest = 0;
    for (const ColumnName& column : missing)
      if (is_numbered(column))
        highest = std::max(highest, column.number);
      else
        names.push_back(column.name);
    std::string text = names.empty() ? "" : describe_missing_columns(names, header_);
    if (names.size() < missing.size())
      text += fmt::format("{}{}, expected at least {}", text.empty() ? "" : "; the table has ",
                          format_count(fields_.size(), "column"), highest);
    return text;
  }

  /// Returns the hint to another separator if the line has one field by the map's separator; otherwise nothing.
  std::string suggest_separator() const {
    if (fields_.size() != 1) return {};
    const auto line = lines_.line();
    for (const auto& [name, separator] : {std::pair("\\t", '\t'), {";", ';'}, {",", ','}})
      if (separator != map_.separator && line.find(separator) != std::string_view::npos)
        return fmt::format("; the line has separators \"{0}\": set separator = \"{0}\" in [file]", name);
    return {};
  }

  bool is_missing(std::string_view text) const {
    return std::ranges::find(missing_texts_, trimmed(text)) != missing_texts_.end();
  }

  /// Returns the fault for a field that is not a number. The time of a row must not be missing.
  Fault not_a_number_fault(const Field& field, bool is_time) const {
    std::string expected = map_.decimal == ',' ? "a number with a decimal comma" : "a number";
    const bool has_comma = field.text.find(',') != std::string_view::npos;
    if (map_.decimal == '.' && has_comma) expected += " with a decimal point";
    if (map_.decimal == '.' && has_comma && map_.separator != ',') expected += ", or decimal = \",\" in [file]";
    const auto shown = plain(in_utf8(field.text));
    if (!is_time && !has_comma && std::ranges::none_of(field.text, [](char c) { return c >= '0' && c <= '9'; }))
      expected += fmt::format(", or missing = [\"{}\"] in [file]", shown);
    if (const auto unit = unit_behind_number(field.text);
        is_utf8(unit) && unit.size() < field.text.size() && !unit.empty())
      expected += fmt::format(", or cell_units = [\"{}\"] in [file]", plain(unit));
    return fault_at(field.column, fmt::format("\"{}\"{}, expected {}", shown, describe_column(field), expected));
  }

  /// Returns " in column "T1"" for a column with a name in the header.
  std::string describe_column(const Field& field) const {
    const auto at = static_cast<std::size_t>(&field - fields_.data());
    return at < header_.size() ? fmt::format(" in column \"{}\"", plain(header_[at])) : "";
  }

  /// Counts the texts of the missing values of an accepted row.
  void count_missing() {
    constexpr std::size_t kMaxTexts = 8;
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      if (!std::isnan(numbers_[i])) continue;
      MissingTexts& texts = missing_[i];
      const Field& field = fields_[layout_.columns[i]];
      auto text = in_utf8(trimmed(record::unquote(field)));
      if (const auto known = texts.find(text); known != texts.end())
        ++known->second;
      else if (texts.size() < kMaxTexts)
        texts.emplace(std::move(text), 1);
    }
  }

  /// Returns the number of a column, or NaN if its field marks a missing value.
  Result<double> number_at(std::size_t i) {
    const Field& field = fields_[layout_.columns[i]];
    const auto text = trimmed(field.text);
    if (!missing_texts_.empty() && is_missing(text)) return kMissing;
    if (const auto number = record::number_in(style_.normalise(text, changed_))) {
      const bool marks_missing = std::ranges::find(missing_numbers_, *number) != missing_numbers_.end();
      return marks_missing ? kMissing : *number;
    }
    if ((field.has_doubled_quotes || !is_utf8(text)) && is_missing(in_utf8(record::unquote(field)))) return kMissing;
    return failure(not_a_number_fault(field, false));
  }

  Result<void> read_counted_time(ForeignRow& row) {
    const Field& field = fields_[*layout_.time];
    const auto counted = parse_counted_time(style_.normalise(trimmed(field.text), changed_), map_.time_unit);
    if (!counted) return failure(not_a_number_fault(field, true));
    std::optional<double> week;
    if (layout_.week) {
      week = record::number_in(style_.normalise(trimmed(fields_[*layout_.week].text), changed_));
      if (!week) return failure(not_a_number_fault(fields_[*layout_.week], true));
    }
    return clock_.read_number(*counted, week, row);
  }

  Result<void> read_time(ForeignRow& row) {
    if (!layout_.time) return read_interval(row);
    const auto text = trimmed(fields_[*layout_.time].text);
    const auto clock = layout_.clock ? trimmed(fields_[*layout_.clock].text) : std::string_view();
    auto read = map_.time_form == TimeForm::number  ? read_counted_time(row)
                : map_.time_form == TimeForm::clock ? clock_.read_clock(text, row)
                                                    : clock_.read_date(text, clock, row);
    if (!read && read.error().where.empty())
      return failure(fault_at(fields_[*layout_.time].column, std::move(read.error().what)));
    return read;
  }

  /// Sets the time of a row in a table without a time.
  Result<void> read_interval(ForeignRow& row) const {
    if (map_.interval > Duration{} && rows_ > kLongestForeignTime / map_.interval)
      return failure(fault_at(1, "more than ten years after the first row"));
    row.time = map_.interval * rows_;
    return {};
  }

  /// Checks the number of fields. Ignores empty fields after the last column. Rows may lack the last column if its name
  /// is empty, or "Comment", which LabVIEW writes only in rows with a comment.
  Result<void> check_width() {
    while (fields_.size() > layout_.width && is_empty(fields_.back())) fields_.pop_back();
    if (fields_.size() == layout_.width) return {};
    const bool ends_in_separator = !header_.empty() && (header_.back().empty() || header_.back() == "Comment") &&
                                   fields_.size() + 1 == layout_.width;
    if (ends_in_separator && layout_.is_within(fields_.size())) return {};
    return failure(
        fault_at(1, fmt::format("{} fields, expected {}{}", fields_.size(), layout_.width,
                                rows_ > 0 && !map_.leaves_out_damaged ? ", or damaged = \"skip\" in [file]" : "")));
  }

  /// Returns whether the last line has no line end and its last number has fewer decimals than the last numbers of all
  /// earlier rows.
  bool is_torn() {
    constexpr std::int64_t kMinRows = 3;
    const auto text = trimmed(fields_.back().text);
    const std::size_t point = text.find(map_.decimal);
    const std::size_t decimals = point == std::string_view::npos ? 0 : text.size() - point - 1;
    const bool is_last = !lines_.has_end();
    if (rows_ == 0) decimals_ = decimals;
    if (is_last) return rows_ >= kMinRows && decimals_ && decimals < *decimals_;
    if (decimals_ && decimals != *decimals_) decimals_ = std::nullopt;
    return false;
  }

  Result<void> read_row() {
    is_take_fault_ = false;
    if (auto parted = split_line(); !parted) return parted;
    if (!is_layout_final_)
      if (auto located = assign_result(layout_, locate_columns()); !located) return located;
    if (auto fits = check_width(); !fits) return fits;
    ForeignRow row;
    if (auto time = read_time(row); !time) return time;
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (auto number = assign_result(numbers_[i], number_at(i)); !number) return number;
    torn_ = is_torn();
    if (torn_) return {};
    accept_row();
    row.numbers = numbers_;
    auto taken = take_(row);
    is_take_fault_ = !taken;
    if (!taken && taken.error().where.empty())
      return failure(fault_at(layout_.time ? fields_[*layout_.time].column : 1, std::move(taken.error().what)));
    return taken;
  }

  /// Changes the state of the table by a row that was read completely. A row that cannot be read changes nothing.
  void accept_row() {
    is_layout_final_ = true;
    clock_.accept();
    count_missing();
    if (!map_.ignores_other_clocks) watch_other_clocks();
    ++rows_;
  }

  void watch_other_clocks() {
    if (rows_ == 0)
      for (std::size_t i = 0; i < fields_.size(); ++i)
        if (!layout_.has(i))
          other_clocks_.begin(i, i < header_.size() ? header_[i] : std::to_string(i + 1), trimmed(fields_[i].text));
    for (auto& clock : other_clocks_.clocks())
      if (clock.column < fields_.size()) clock.last = trimmed(fields_[clock.column].text);
  }

  TextLines lines_;
  const ImportMap& map_;
  const TakeRow& take_;
  std::vector<ColumnName> columns_;
  NumberStyle style_;
  RowClock clock_;
  std::vector<double> numbers_;
  std::vector<MissingTexts> missing_;
  /// The texts that mark missing values, without blanks at their ends, and those of them that are numbers.
  std::vector<std::string> missing_texts_{};
  std::vector<double> missing_numbers_{};
  std::vector<std::string> header_{};
  std::vector<Field> fields_{};
  TableLayout layout_{};
  /// The layout was found in the header or in an accepted row. Until then, each line is examined anew.
  bool is_layout_final_ = false;
  OtherClocks other_clocks_{};
  DamagedLines damaged_{};
  /// The number of decimals of the last field; nothing if it differs between rows.
  std::optional<std::size_t> decimals_{};
  bool torn_ = false;  ///< the last line was left out
  /// The last fault came from the caller's `take`; the row itself was read successfully.
  bool is_take_fault_ = false;
  std::string changed_{};
  std::int64_t rows_{};
};

}  // namespace

bool has_good_thousands(std::string_view number, char thousands, char decimal) {
  if (number.starts_with('-') || number.starts_with('+')) number.remove_prefix(1);
  const auto whole = number.substr(0, number.find(decimal));
  const auto behind = number.substr(std::min(whole.size(), number.size()));
  if (behind.find(thousands) != std::string_view::npos) return false;
  std::size_t first = whole.find(thousands);
  if (first == std::string_view::npos) return true;
  if (first == 0 || first > 3) return false;
  for (std::size_t at = first; at < whole.size(); at += 4)
    if (whole[at] != thousands || whole.size() < at + 4 ||
        whole.substr(at + 1, 3).find_first_not_of(kAllDigits) != std::string_view::npos)
      return false;
  return true;
}

std::string_view unit_behind_number(std::string_view cell) {
  cell = trimmed(cell);
  for (const auto minus : {kMinusSign, kEnDash})
    if (cell.starts_with(minus)) cell.remove_prefix(minus.size());
  const std::size_t number = cell.find_last_of(kAllDigits);
  if (cell.empty() || number == std::string_view::npos) return {};
  const bool starts_as_number = cell.find_first_of(kAllDigits) <= 1;
  const auto unit = trimmed(cell.substr(number + 1));
  const bool is_number = cell.substr(0, number + 1).find_first_not_of("0123456789.,+-eE") == std::string_view::npos;
  constexpr std::size_t kMaxUnitLength = 12;
  return starts_as_number && is_number && unit.size() <= kMaxUnitLength && unit != "." && unit != ","
             ? unit
             : std::string_view();
}

std::string_view NumberStyle::normalise(std::string_view text, std::string& changed) const {
  if (is_plain(text, *this) || text.empty()) return text;
  changed = strip_unit(text, units);
  if (static_cast<unsigned char>(changed.front()) >= 0x80 || thousands == ' ') {
    for (const auto minus : {kMinusSign, kEnDash}) changed = substitute(changed, minus, "-");
    for (const auto blank : {kNoBreakSpace, kNarrowSpace}) changed = substitute(changed, blank, " ");
  }
  if (changed.starts_with("- ")) changed.erase(1, 1);
  if (thousands != 0) {
    if (!has_good_thousands(changed, thousands, decimal)) return {};
    std::erase(changed, thousands);
  }
  if (decimal == '.') return changed;
  if (changed.find('.') != std::string::npos) return {};
  std::ranges::replace(changed, ',', '.');
  return changed;
}

Result<Findings> read_text_table(Bytes bytes, const ImportMap& map, const TakeRow& take) {
  auto lines = TextLines::open(std::move(bytes), map.comment);
  if (!lines) return failure(lines.error());
  return TextTable(std::move(*lines), map, take).read();
}

}  // namespace gyrotherm::exchange
