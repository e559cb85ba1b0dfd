// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "acquisition/exchange/civil_time.hpp"
#include "acquisition/exchange/counted_time.hpp"
#include "acquisition/exchange/text_lines.hpp"
#include "acquisition/record/csv.hpp"
#include "acquisition/record/row.hpp"
#include "core/text.hpp"

namespace gyrotherm::exchange {

namespace {

using record::Field, record::into, record::kMissing;

/// One pass over the file; the first fault ends it.
class TextTable {
 public:
  TextTable(TextLines lines, const ImportMap& map, const TakeRow& take)
      : lines_(std::move(lines)), map_(map), take_(take), columns_(map.columns()), numbers_(columns_.size()) {
    if (map.since) since_ = counted_time(map.since->count(), Duration(1));
  }

  Result<void> read() {
    if (map_.header)
      if (auto header = read_header(); !header) return header;
    for (std::size_t i = 0; i < map_.skip; ++i)
      if (auto line = expect(lines_.pass(), "the file ends among the lines to skip"); !line) return line;
    while (true) {
      const auto line = lines_.next();
      if (!line) return failure(line.error());
      if (!*line) break;
      if (auto row = read_row(); !row) return row;
    }
    if (rows_ == 0) return failure(mistake(1, "the file ends, expected at least one row"));
    return {};
  }

 private:
  Fault mistake(std::size_t column, std::string what) const { return lines_.mistake(column, std::move(what)); }

  Result<void> expect(const Result<bool>& line, const char* otherwise) const {
    if (!line) return failure(line.error());
    return *line ? Result<void>{} : failure(mistake(1, otherwise));
  }

  Result<void> part_line() {
    auto parted = record::cut(lines_.line(), map_.separator, fields_);
    if (!parted) return failure(mistake(std::stoul(parted.error().where), std::move(parted.error().what)));
    return parted;
  }

  Result<void> read_header() {
    if (auto line = expect(lines_.next(), "the file ends, expected a header"); !line) return line;
    if (auto parted = part_line(); !parted) return parted;
    for (const Field& field : fields_) header_.push_back(in_utf8(trimmed(record::unquoted(field))));
    width_ = fields_.size();
    return locate_columns();
  }

  /// Where a column stands; the number of columns if it is none of them.
  Result<std::size_t> place_of(const ColumnName& column) const {
    if (!map_.header) return std::min(column.number - 1, width_);
    const std::string wanted(trimmed(column.name));
    const auto found = std::ranges::find(header_, wanted);
    if (found == header_.end()) return width_;
    const auto place = static_cast<std::size_t>(found - header_.begin());
    if (const auto again = std::find(found + 1, header_.end(), wanted); again != header_.end())
      return failure(mistake(fields_[static_cast<std::size_t>(again - header_.begin())].column,
                             fmt::format("a second column \"{}\", expected one", column.name)));
    return place;
  }

  /// By the header, or by the first row's width.
  Result<void> locate_columns() {
    std::vector<std::string> missing;
    std::size_t highest = 0;
    const auto locate = [&](const ColumnName& column) -> Result<std::size_t> {
      const auto place = place_of(column);
      if (place && *place == width_) missing.push_back(column.name);
      highest = std::max(highest, column.number);
      return place;
    };
    if (map_.time)
      if (auto place = into(time_at_.emplace(), locate(*map_.time)); !place) return place;
    for (const ColumnName& column : columns_)
      if (auto place = into(places_.emplace_back(), locate(column)); !place) return place;
    if (missing.empty()) return {};
    return failure(mistake(1, map_.header ? describe_missing_columns(missing, header_)
                                          : fmt::format("{} columns, expected at least {}", width_, highest)));
  }

  bool is_missing(std::string_view text) const { return std::ranges::find(map_.missing, text) != map_.missing.end(); }

  /// What is no number stays none.
  std::string_view with_decimal_point(std::string_view text) {
    if (map_.decimal == '.') return text;
    if (text.find('.') != std::string_view::npos) return {};
    decimal_ = text;
    std::ranges::replace(decimal_, ',', '.');
    return decimal_;
  }

  /// A row's time must be there.
  Fault no_number(const Field& field, bool is_time) const {
    std::string expected = map_.decimal == ',' ? "a number with a decimal comma" : "a number";
    const bool has_comma = field.text.find(',') != std::string_view::npos;
    if (map_.decimal == '.' && has_comma) expected += " with a decimal point";
    if (map_.decimal == '.' && has_comma && map_.separator != ',') expected += ", or decimal = \",\" in [file]";
    if (!is_time && !has_comma && std::ranges::none_of(field.text, [](char c) { return c >= '0' && c <= '9'; }))
      expected += fmt::format(", or missing = [\"{}\"] in [file]", plain(in_utf8(field.text)));
    return mistake(field.column, fmt::format("\"{}\", expected {}", plain(in_utf8(field.text)), expected));
  }

  Result<double> number_at(std::size_t index) {
    const Field& field = fields_[index];
    const auto text = trimmed(field.text);
    if (!map_.missing.empty() && is_missing(text)) return kMissing;
    if (const auto number = record::number_in(with_decimal_point(text))) return *number;
    const bool is_missing_text = field.has_doubled_quotes || !is_utf8(text);
    if (is_missing_text && is_missing(in_utf8(record::unquoted(field)))) return kMissing;
    return failure(no_number(field, false));
  }

  Result<void> read_number_of_time(ForeignRow& row) {
    const Field& field = fields_[*time_at_];
    const auto counted = parse_counted_time(with_decimal_point(trimmed(field.text)), map_.time_unit);
    if (!counted) return failure(no_number(field, true));
    if (!first_number_) first_number_ = *counted;
    const auto since_first = between(*first_number_, *counted);
    if (!since_first) return failure(mistake(field.column, "more than ten years after the first row"));
    row.time = *since_first;
    if (!since_) return {};
    row.utc = utc_of(*since_ + *counted);
    if (row.utc) return {};
    return failure(mistake(field.column, "a time outside 1970 to 2116: do unit and since in [time] fit?"));
  }

  Result<void> read_civil_time(ForeignRow& row) {
    const Field& field = fields_[*time_at_];
    const auto time = parse_civil_time(trimmed(field.text));
    if (!time)
      return failure(mistake(field.column, fmt::format("\"{}\", expected a time like \"2026-03-01T12:30:05.25Z\"",
                                                       plain(in_utf8(field.text)))));
    const auto zone = time->zone ? time->zone : map_.zone;
    if (!zone)
      return failure(mistake(field.column, fmt::format("\"{}\" has no zone, expected one behind it, or zone = \"Z\" "
                                                       "in [time]",
                                                       field.text)));
    row.utc = time->reading - *zone;
    if (!record::is_possible_time(*row.utc)) return failure(mistake(field.column, "a time outside 1970 to 2116"));
    if (!first_utc_) first_utc_ = *row.utc;
    row.time = *row.utc - *first_utc_;
    if (std::chrono::abs(row.time) <= kLongestForeignTime) return {};
    return failure(mistake(field.column, "more than ten years after the first row"));
  }

  Result<void> read_time(ForeignRow& row) {
    if (time_at_) return map_.time_form == TimeForm::civil ? read_civil_time(row) : read_number_of_time(row);
    row.time = map_.interval * rows_;
    return {};
  }

  Result<void> read_row() {
    if (auto parted = part_line(); !parted) return parted;
    if (width_ == 0) {
      width_ = fields_.size();
      if (auto located = locate_columns(); !located) return located;
    }
    if (fields_.size() != width_)
      return failure(mistake(1, fmt::format("{} fields, expected {}", fields_.size(), width_)));
    ForeignRow row;
    if (auto time = read_time(row); !time) return time;
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (auto number = into(numbers_[i], number_at(places_[i])); !number) return number;
    row.numbers = numbers_;
    ++rows_;
    auto taken = take_(row);
    if (!taken && taken.error().where.empty())
      return failure(mistake(time_at_ ? fields_[*time_at_].column : 1, std::move(taken.error().what)));
    return taken;
  }

  TextLines lines_;
  const ImportMap& map_;
  const TakeRow& take_;
  std::vector<ColumnName> columns_;
  std::vector<double> numbers_;
  std::vector<std::string> header_{};
  std::vector<Field> fields_{};
  std::size_t width_{};  ///< fields of the header, or of the first row
  std::optional<std::size_t> time_at_{};
  std::vector<std::size_t> places_{};
  std::optional<CountedTime> since_{};  ///< after 1970, if the map says so
  std::optional<CountedTime> first_number_{};
  std::optional<Duration> first_utc_{};
  std::string decimal_{};
  std::int64_t rows_{};
};

}  // namespace

Result<void> read_text_table(Bytes bytes, const ImportMap& map, const TakeRow& take) {
  auto lines = TextLines::open(std::move(bytes), map.comment);
  if (!lines) return failure(lines.error());
  return TextTable(std::move(*lines), map, take).read();
}

}  // namespace gyrotherm::exchange
