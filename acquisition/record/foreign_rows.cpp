#include "acquisition/record/foreign_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "acquisition/record/csv_line.hpp"

namespace gyrotherm {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr double kLongestTimeS = 3e8;  // ten years; far inside what 64 bits of nanoseconds hold
constexpr int kSilence = 10;           // times the median spacing

/// One pass over the file: lines are taken off `rest_`, the first fault ends it.
class Reader {
 public:
  Reader(std::string_view text, const ImportMap& map, const std::string& file) : rest_(text), map_(map), file_(file) {
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
    rows_.thermometers_c.resize(map.thermometers.size());
  }

  Result<ForeignRows> read();

 private:
  bool next_line();
  Result<void> part_line();
  Result<void> read_header();
  Result<std::size_t> place_of(const ColumnName& column) const;
  Result<void> locate_columns();
  Result<double> number_at(std::size_t index) const;
  Result<void> read_time();
  Result<void> read_row();
  Fault mistake(std::size_t column, std::string what) const;

  std::string_view rest_;
  const ImportMap& map_;
  const std::string& file_;
  std::string_view line_;
  std::size_t line_number_{};
  std::vector<Field> fields_;
  std::size_t width_{};  ///< fields of the header, or of the first row
  std::optional<std::size_t> time_at_;
  std::vector<std::size_t> thermometers_at_;
  std::size_t gyro_at_{};
  std::optional<double> first_time_;
  ForeignRows rows_;
};

Fault Reader::mistake(std::size_t column, std::string what) const {
  return {FaultKind::bad_file, fmt::format("{}:{}:{}", file_, line_number_, column), std::move(what)};
}

/// Goes to the next line that is neither empty nor a comment; what is passed over may be of any length.
bool Reader::next_line() {
  while (!rest_.empty()) {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++line_number_;
    if (line_.ends_with('\r')) line_.remove_suffix(1);
    const bool comment = !map_.comment.empty() && line_.starts_with(map_.comment);
    if (!comment && !trimmed(line_).empty()) return true;
  }
  return false;
}

Result<void> Reader::part_line() {
  if (line_.size() > kLongestLine)
    return failure(
        mistake(kLongestLine + 1, fmt::format("more than {} bytes in a line, expected fewer", kLongestLine)));
  auto parted = cut(line_, map_.separator, fields_);
  if (!parted) parted.error().where = fmt::format("{}:{}:{}", file_, line_number_, parted.error().where);
  return parted;
}

Result<std::size_t> Reader::place_of(const ColumnName& column) const {
  if (!map_.header) {
    if (column.number <= width_) return column.number - 1;
    return failure(mistake(1, fmt::format("{} columns, expected at least {}", width_, column.number)));
  }
  const auto same = [&](const Field& field) { return trimmed(field.text) == trimmed(column.name); };
  const auto found = std::find_if(fields_.begin(), fields_.end(), same);
  if (found == fields_.end()) return failure(mistake(1, fmt::format("no column \"{}\" in the header", column.name)));
  if (const auto again = std::find_if(found + 1, fields_.end(), same); again != fields_.end())
    return failure(mistake(again->column, fmt::format("a second column \"{}\", expected one", column.name)));
  return static_cast<std::size_t>(found - fields_.begin());
}

/// From the header, or from the first row's width.
Result<void> Reader::locate_columns() {
  width_ = fields_.size();
  if (map_.time) {
    const auto place = place_of(*map_.time);
    if (!place) return failure(place.error());
    time_at_ = *place;
  }
  for (const auto& thermometer : map_.thermometers) {
    const auto place = place_of(thermometer.column);
    if (!place) return failure(place.error());
    thermometers_at_.push_back(*place);
  }
  const auto place = place_of(map_.gyro);
  if (!place) return failure(place.error());
  gyro_at_ = *place;
  return {};
}

Result<void> Reader::read_header() {
  if (!next_line()) return failure(mistake(1, "the file ends, expected a header"));
  if (auto parted = part_line(); !parted) return parted;
  return locate_columns();
}

Result<double> Reader::number_at(std::size_t index) const {
  const Field& field = fields_[index];
  if (const auto number = number_in(trimmed(field.text))) return *number;
  const char* hint = field.text.find(',') != std::string_view::npos ? " with a decimal point" : "";
  return failure(mistake(field.column, fmt::format("\"{}\", expected a number{}", field.text, hint)));
}

Result<void> Reader::read_time() {
  if (!time_at_) {
    rows_.time.push_back(map_.interval * static_cast<Duration::rep>(rows_.time.size()));
    return {};
  }
  const auto number = number_at(*time_at_);
  if (!number) return failure(number.error());
  if (!first_time_) first_time_ = *number;
  const double time_s = (*number - *first_time_) * to_seconds(map_.time_unit);
  const std::size_t column = fields_[*time_at_].column;
  if (std::abs(time_s) > kLongestTimeS) return failure(mistake(column, "more than ten years after the first row"));
  const Duration time = from_seconds(time_s);
  if (!rows_.time.empty() && time <= rows_.time.back())
    return failure(mistake(column, "the time does not increase, expected one after the row before"));
  rows_.time.push_back(time);
  return {};
}

Result<void> Reader::read_row() {
  if (fields_.size() != width_)
    return failure(mistake(1, fmt::format("{} fields, expected {}", fields_.size(), width_)));
  if (auto time = read_time(); !time) return time;
  for (std::size_t i = 0; i < thermometers_at_.size(); ++i) {
    const auto number = number_at(thermometers_at_[i]);
    if (!number) return failure(number.error());
    const auto& thermometer = map_.thermometers[i];
    rows_.thermometers_c[i].push_back(*number * thermometer.scale + thermometer.offset_c);
  }
  const auto number = number_at(gyro_at_);
  if (!number) return failure(number.error());
  rows_.gyro.push_back(*number);
  return {};
}

Result<ForeignRows> Reader::read() {
  if (map_.header)
    if (auto header = read_header(); !header) return failure(header.error());
  for (std::size_t i = 0; i < map_.skip; ++i)
    if (!next_line()) return failure(mistake(1, "the file ends among the lines to skip"));
  while (next_line()) {
    if (auto parted = part_line(); !parted) return failure(parted.error());
    if (width_ == 0)
      if (auto located = locate_columns(); !located) return failure(located.error());
    if (auto row = read_row(); !row) return failure(row.error());
  }
  if (rows_.gyro.empty()) return failure(mistake(1, "the file ends, expected at least one row"));
  return std::move(rows_);
}

std::vector<Duration> spacings(const std::vector<Duration>& time) {
  std::vector<Duration> spacing;
  for (std::size_t i = 1; i < time.size(); ++i) spacing.push_back(time[i] - time[i - 1]);
  return spacing;
}

Duration median(std::vector<Duration> values) {
  if (values.empty()) return {};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Duration> intervals(const std::vector<Duration>& time, const ImportMap& map) {
  if (!map.time) return std::vector<Duration>(time.size(), map.interval);
  std::vector<Duration> interval = spacings(time);
  const Duration usual = median(interval);
  interval.insert(interval.begin(), usual);
  if (map.gyro_info.kind == GyroKind::rate) std::fill(interval.begin(), interval.end(), usual);
  return interval;
}

}  // namespace

Result<ForeignRows> parse_foreign_rows(std::string_view text, const ImportMap& map, const std::string& file) {
  auto rows = Reader(text, map, file).read();
  if (rows) rows->interval = intervals(rows->time, map);
  return rows;
}

Silences find_silences(const std::vector<Duration>& time) {
  const std::vector<Duration> spacing = spacings(time);
  Silences silences{.median = median(spacing)};
  for (std::size_t i = 0; i < spacing.size(); ++i) {
    if (spacing[i] <= kSilence * silences.median) continue;
    if (silences.count == 0) {
      silences.first_after = i;
      silences.first = spacing[i];
    }
    ++silences.count;
    silences.total += spacing[i];
  }
  return silences;
}

}  // namespace gyrotherm
