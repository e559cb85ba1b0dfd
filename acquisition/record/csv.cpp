// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <variant>

#include "acquisition/record/record.hpp"
#include "acquisition/record/row.hpp"
#include "core/text.hpp"

namespace gyrotherm::record {

namespace {

constexpr std::string_view kBlanks = " \t\r";

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

tl::unexpected<LineFault> line_failure(std::size_t at, std::string what) {
  return tl::unexpected(LineFault{at + 1, std::move(what)});
}

/// Parses the quoted field that begins at `from`. Returns the position after its closing quote.
tl::expected<std::size_t, LineFault> take_quoted(std::string_view line, std::size_t from, std::vector<Field>& fields) {
  bool has_doubled_quotes = false;
  std::size_t close = line.find('"', from + 1);
  while (close != std::string_view::npos && close + 1 < line.size() && line[close + 1] == '"') {
    has_doubled_quotes = true;
    close = line.find('"', close + 2);
  }
  if (close == std::string_view::npos)
    return line_failure(from, "a quote is not closed, expected \" before the end of the line");
  fields.push_back({line.substr(from + 1, close - from - 1), from + 1, has_doubled_quotes});
  return close + 1;
}

tl::unexpected<LineFault> text_after_quote_failure(std::size_t at) {
  return line_failure(at, "text after a closing quote, expected a separator");
}

/// Returns the position of the separator after a quoted field, or npos at the end of the line.
tl::expected<std::size_t, LineFault> separator_after(std::string_view line, std::size_t quoted_end, char separator) {
  const std::size_t next = line.find(separator, quoted_end);
  const std::string_view rest = line.substr(quoted_end, next == std::string_view::npos ? next : next - quoted_end);
  if (trimmed(rest).empty()) return next;
  return text_after_quote_failure(quoted_end);
}

tl::unexpected<LineFault> too_many_fields_failure(std::size_t from) {
  return line_failure(from, fmt::format("more than {} fields, expected fewer", kMaxFields));
}

tl::expected<void, LineFault> split_at_blanks(std::string_view line, std::vector<Field>& fields) {
  std::size_t from = line.find_first_not_of(kBlanks);
  while (from != std::string_view::npos) {
    if (fields.size() == kMaxFields) return too_many_fields_failure(from);
    std::size_t to = from;
    if (line[from] == '"') {
      const auto end = take_quoted(line, from, fields);
      if (!end) return tl::unexpected(end.error());
      if (*end < line.size() && !is_blank(line[*end])) return text_after_quote_failure(*end);
      to = *end;
    } else {
      to = std::min(line.find_first_of(kBlanks, from), line.size());
      fields.push_back({line.substr(from, to - from), from + 1});
    }
    from = line.find_first_not_of(kBlanks, to);
  }
  return {};
}

}  // namespace

std::string_view trimmed(std::string_view text) { return gyrotherm::trimmed(text, kBlanks); }

std::string unquote(const Field& field) {
  if (!field.has_doubled_quotes) return std::string(field.text);
  std::string text;
  for (std::size_t i = 0; i < field.text.size(); ++i) {
    text += field.text[i];
    if (field.text[i] == '"') ++i;
  }
  return text;
}

std::optional<double> number_in(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

tl::expected<void, LineFault> split_line(std::string_view line, char separator, std::vector<Field>& fields) {
  fields.clear();
  if (separator == ' ') return split_at_blanks(line, fields);
  for (std::size_t from = 0;;) {
    if (fields.size() == kMaxFields) return too_many_fields_failure(from);
    std::size_t to = from, first = from;
    while (first < line.size() && is_blank(line[first]) && line[first] != separator) ++first;
    if (first < line.size() && line[first] == '"') {
      const auto next = take_quoted(line, first, fields).and_then([&](std::size_t end) {
        return separator_after(line, end, separator);
      });
      if (!next) return tl::unexpected(next.error());
      to = *next;
    } else {
      to = line.find(separator, from);
      fields.push_back({trimmed(line.substr(from, to == std::string_view::npos ? to : to - from)), from + 1});
    }
    if (to == std::string_view::npos) return {};
    from = to + 1;
  }
}

tl::unexpected<Fault> LiveRows::fault_at(std::size_t column, std::string what) const {
  return failure(FaultKind::bad_file, fmt::format("{}:{}:{}", source_, line_, column), std::move(what));
}

Result<void> LiveRows::take(std::string_view piece) {
  while (true) {
    const std::size_t end = piece.find('\n');
    const bool whole = end != std::string_view::npos;
    std::string_view line = piece.substr(0, end);
    if (line.size() > kLongestLine || line.size() + rest_.size() > kLongestLine) {
      ++line_;
      return fault_at(1, fmt::format("more than {} bytes without an end of line", kLongestLine));
    }
    if (!whole || !rest_.empty()) rest_ += line;
    if (!whole) return {};
    if (!rest_.empty()) line = rest_;
    if (auto read = read_line(line); !read) return read;
    rest_.clear();
    piece.remove_prefix(end + 1);
  }
}

Result<void> LiveRows::finish() {
  if (!rest_.empty()) {
    if (auto read = read_line(rest_); !read) return read;
    rest_.clear();
  }
  if (!header_.empty()) return {};
  ++line_;
  return fault_at(1, "no input, expected a header");
}

Result<void> LiveRows::read_line(std::string_view line) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (++line_ == 1 && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  if (trimmed(line).empty()) return {};
  if (header_.empty() && line.starts_with('#')) {
    comments_.emplace_back(trimmed(line.substr(1)));
    return {};
  }
  if (auto parted = split_line(line, ',', fields_); !parted)
    return fault_at(parted.error().column, std::move(parted.error().what));
  return header_.empty() ? read_header() : read_row();
}

Result<void> LiveRows::read_header() {
  for (const Field& field : fields_) header_.push_back(unquote(field));
  if (!choose_) {
    columns_.resize(header_.size());
    std::iota(columns_.begin(), columns_.end(), std::size_t{});
    return {};
  }
  auto chosen = choose_(header_, comments_);
  if (!chosen) return failure(chosen.error());
  columns_ = std::move(*chosen);
  return {};
}

Result<void> LiveRows::read_row() {
  if (fields_.size() != header_.size()) {
    return fault_at(1, fmt::format("{} fields, expected {}", fields_.size(), header_.size()));
  }
  const std::size_t before = numbers_.size();
  for (const std::size_t at : columns_) {
    const Field& field = fields_[at];
    numbers_.push_back(std::numeric_limits<double>::quiet_NaN());
    if (field.text.empty()) continue;
    const auto number = number_in(field.text);
    if (!number) {
      numbers_.resize(before);
      return fault_at(field.column, fmt::format("\"{}\", expected a number", field.text));
    }
    numbers_.back() = *number;
  }
  lines_.push_back(line_);
  return {};
}

namespace {

using Buffer = fmt::memory_buffer;

void add(Buffer& out, std::string_view text) { out.append(text); }

/// Writes a text field, in quotes if necessary.
void add_field(Buffer& out, std::string_view text) {
  if (text.find_first_of(",\"\r\n#") == std::string_view::npos) return add(out, text);
  out.push_back('"');
  for (const char c : text) {
    if (c == '"') out.push_back('"');
    out.push_back(c);
  }
  out.push_back('"');
}

/// Writes a field, preceded by a comma unless it is the first of its line.
void add_cell(Buffer& out, const Cell& cell) {
  if (out[out.size() - 1] != '\n') out.push_back(',');
  if (const auto* text = std::get_if<std::string_view>(&cell)) add_field(out, *text);
  if (const auto* whole = std::get_if<std::int64_t>(&cell)) fmt::format_to(std::back_inserter(out), "{}", *whole);
  if (const auto* number = std::get_if<double>(&cell); number && !std::isnan(*number))
    fmt::format_to(std::back_inserter(out), "{}", *number);
}

/// Makes a text suitable for a comment: on one line and without control characters.
std::string to_one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return plain(text);
}

/// Writes the thermometers of a unit. Analyses of the exported rows require them.
void add_unit_comments(Buffer& out, const UnitInfo& unit) {
  const auto add_list = [&](std::string_view title, const std::vector<std::string>& names) {
    if (names.empty()) return;
    fmt::format_to(std::back_inserter(out), "# unit {}: {} {}\n", to_one_line(unit.name), title,
                   to_one_line(fmt::format("{}", fmt::join(names, ", "))));
  };
  add_list("gradients", unit.gradients);
  add_list("three point", unit.three_point);
}

void add_comments(Buffer& out, const RunInfo& info, bool finished) {
  if (is_simulated(info))
    fmt::format_to(std::back_inserter(out), "# SIMULATED: {}\n", to_one_line(describe_simulation(info)));
  for (const ProgramRelease& release : info.releases)
    fmt::format_to(std::back_inserter(out), "# {}\n", to_one_line(describe(release)));
  fmt::format_to(std::back_inserter(out), "# run {} of {} on {}{}\n", to_one_line(info.id),
                 to_one_line(info.profile_name), to_one_line(info.rig_name), finished ? "" : ", not finished");
  for (const UnitInfo& unit : info.units)
    for (std::size_t axis = 0; axis < unit.axes.size(); ++axis) {
      fmt::format_to(std::back_inserter(out), "# axis {}: scale {}", to_one_line(axis_label(unit, axis)),
                     unit.axes[axis].scale);
      if (const auto& rate = unit.axes[axis].earth_rate)
        fmt::format_to(std::back_inserter(out), ", earth rate {}", rate->value);
      else if (info.imported)
        add(out, ", nothing removed");
      out.push_back('\n');
    }
  for (const UnitInfo& unit : info.units) add_unit_comments(out, unit);
  for (const Channel& channel : info.thermometers) {
    const std::string name = to_one_line(channel.name);
    if (!channel.polynomial.empty()) {
      fmt::format_to(std::back_inserter(out), "# thermometer {}: polynomial {}\n", name,
                     fmt::join(channel.polynomial, " "));
    } else if (channel.offset.value != 0) {
      fmt::format_to(std::back_inserter(out), "# thermometer {}: offset {}\n", name, channel.offset.value);
    }
  }
}

std::string column_title(const ChannelColumn& column, const RunInfo& info) {
  if (column.measures == Measures::temperature) return column.name + " [°C]";
  if (is_of_chamber(column.measures))
    return column.measures == Measures::humidity ? "chamber humidity [%]" : "chamber dew point [°C]";
  const UnitInfo& unit = info.units[column.unit];
  switch (column.measures) {
    case Measures::rotation: {
      const AxisInfo& axis = unit.axes[column.index];
      const auto* pulses = axis.kind == GyroKind::pulse_count ? "pulses of " : "";
      const auto* of = axis.kind == GyroKind::pulse_count ? "arcsec" : "°/h";
      return fmt::format("{} [{}{} {}]", axis_label(unit, column.index), pulses, axis.scale, of);
    }
    case Measures::interval: return unit.name + " interval [s]";
    case Measures::value: return fmt::format("{} [{}]", column.name, unit.values[column.index].unit);
    case Measures::true_bias:
      return info.units.size() == 1 && unit.axes.size() == 1 ? "true bias [°/h]"
                                                             : axis_label(unit, column.index) + " true bias [°/h]";
    case Measures::humidity:
    case Measures::dew_point:
    case Measures::temperature: break;
  }
  return column.name;
}

/// Returns the value in a row, or NaN if the column is shorter, as in a record built by hand.
double number_at(const std::vector<double>& column, std::size_t row) {
  return row < column.size() ? column[row] : kMissing;
}

double channel_value(const Record& record, const ChannelColumn& column, std::size_t row) {
  if (column.measures == Measures::temperature) return number_at(record.thermometers_c[column.index], row);
  if (column.measures == Measures::humidity) return number_at(record.chamber_humidity_percent, row);
  if (column.measures == Measures::dew_point) return number_at(record.chamber_dew_point_c, row);
  const UnitColumns& unit = record.units[column.unit];
  switch (column.measures) {
    case Measures::rotation: return number_at(unit.rotation[column.index], row);
    case Measures::value: return number_at(unit.values[column.index], row);
    case Measures::true_bias: return number_at(unit.true_bias_deg_per_h[column.index], row);
    case Measures::humidity:
    case Measures::dew_point:
    case Measures::interval:
    case Measures::temperature: break;
  }
  return number_at(unit.interval_s, row);
}

/// Selects the column with the mounting of the unit.
struct TurnedColumn {};

/// Calls `use` with each column of the text table, in order. A column is one that every record has, one of a channel,
/// or TurnedColumn if `has_operator_actions`.
void each_column(std::span<const ChannelColumn> channels, bool has_operator_actions, const auto& use) {
  const auto each_fixed = [&](std::span<const Column<SampleRow>> columns) {
    for (const auto& column : columns)
      if (column.exported.title != nullptr) use(column);
  };
  const auto is_truth = [](const ChannelColumn& column) { return column.measures == Measures::true_bias; };
  const auto truth = std::ranges::find_if(channels, is_truth);
  each_fixed(columns_before_channels());
  std::for_each(channels.begin(), truth, use);
  each_fixed(columns_after_channels());
  if (has_operator_actions) use(TurnedColumn{});
  std::for_each(truth, channels.end(), use);
}

struct TitleWriter {
  Buffer& out;
  const RunInfo& info;
  void operator()(const Column<SampleRow>& column) const { add_cell(out, std::string_view(column.exported.title)); }
  void operator()(const ChannelColumn& column) const { add_cell(out, column_title(column, info)); }
  void operator()(TurnedColumn) const { add_cell(out, kTurnedTitle); }
};

struct CellWriter {
  Buffer& out;
  const Record& record;
  std::size_t row;
  void operator()(const Column<SampleRow>& column) const { add_cell(out, column.exported.cell(record, row)); }
  void operator()(const ChannelColumn& column) const { add_cell(out, channel_value(record, column, row)); }
  void operator()(TurnedColumn) const { add_cell(out, turned_at(record, row)); }
};

}  // namespace

void write_csv_head(const RunInfo& info, bool finished, const std::function<void(std::string_view)>& sink) {
  Buffer out;
  add_comments(out, info, finished);
  each_column(channel_columns(info), has_operator_actions(info), TitleWriter{out, info});
  out.push_back('\n');
  sink(std::string_view(out.data(), out.size()));
}

void write_csv_rows(const Record& record, std::int64_t after, const std::function<void(std::string_view)>& sink) {
  constexpr std::size_t kPieceBytes = 1 << 16;
  Buffer out;
  const auto channels = channel_columns(record.info);
  out.push_back('\n');
  // The buffer begins with a newline, from which add_cell() detects the start of a line. The newline is not passed to
  // `sink`.
  std::size_t begun = 1;
  const auto flush = [&] {
    sink(std::string_view(out.data(), out.size()).substr(begun));
    out.clear();
    out.push_back('\n');
    begun = 1;
  };
  const bool handled = has_operator_actions(record.info);
  for (std::size_t row = 0; row < record.slot.size(); ++row) {
    if (record.slot[row] <= after) continue;
    each_column(channels, handled, CellWriter{out, record, row});
    out.push_back('\n');
    if (out.size() > kPieceBytes) flush();
  }
  flush();
}

void write_csv(const Record& record, const std::function<void(std::string_view)>& sink) {
  write_csv_head(record.info, record.finished, sink);
  write_csv_rows(record, -1, sink);
}

std::string to_csv(const Record& record) {
  std::string text;
  write_csv(record, [&](std::string_view piece) { text += piece; });
  return text;
}

}  // namespace gyrotherm::record
