// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/table_sample.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "acquisition/exchange/column_names.hpp"
#include "acquisition/exchange/foreign_time.hpp"
#include "acquisition/exchange/lvm_layout.hpp"
#include "acquisition/exchange/text_lines.hpp"
#include "acquisition/record/csv.hpp"
#include "core/text.hpp"
#include "core/toml_text.hpp"

namespace gyrotherm::exchange {

namespace {

struct Line {
  std::size_t number{};
  std::string text{};
};
using Fields = std::vector<std::string>;

constexpr std::size_t kMaxLines = 100'000, kMaxBytes = 32 << 20;

std::optional<Fields> split_fields(const std::string& line, char separator) {
  std::vector<record::Field> fields;
  Fields texts;
  if (!record::split_line(line, separator, fields)) return std::nullopt;
  for (const auto& field : fields) texts.push_back(in_utf8(trimmed(record::unquote(field))));
  return texts;
}

/// Returns the number of fields without the empty ones at the end.
std::size_t filled_width(const Fields& fields) {
  std::size_t width = fields.size();
  while (width > 0 && fields[width - 1].empty()) --width;
  return width;
}

bool has_digit(std::string_view text) { return text.find_first_of("0123456789") != std::string_view::npos; }

/// Returns whether a field may be a time, or a number in any notation.
bool is_value(const std::string& field) {
  if (field.empty()) return false;
  std::string_view text = field;
  text = text.substr(0, text.size() - unit_behind_number(text).size());
  if (text.starts_with(kMinusSign)) text.remove_prefix(kMinusSign.size());
  const bool is_number =
      has_digit(text) && text.find_first_not_of("0123456789.,'+-eE \xC2\xA0") == std::string_view::npos;
  const bool starts_as_one = has_digit(text.substr(0, 1)) || text.starts_with('-') || text.starts_with('+') ||
                             text.starts_with('.') || text.starts_with(',');
  return (is_number && starts_as_one) || parse_clock(field) || parse_civil_time(field) ||
         parse_local_time(field, DateOrder::day_first) || parse_local_time(field, DateOrder::month_first) ||
         parse_local_time(field, DateOrder::year_first);
}

std::size_t count_values(const Fields& fields) {
  return static_cast<std::size_t>(std::ranges::count_if(fields, is_value));
}

Result<std::vector<Line>> read_sample_lines(Bytes bytes, TableSample& sample) {
  auto lines = TextLines::open(std::move(bytes), "");
  if (!lines) return failure(lines.error());
  std::vector<Line> all;
  std::size_t size = 0;
  while (all.size() < kMaxLines && size < kMaxBytes) {
    const auto next = lines->next();
    if (next && !*next) break;
    if (next) {
      size += lines->line().size();
      all.push_back({lines->number(), std::string(lines->line())});
      continue;
    }
    if (all.empty()) return failure(next.error());
    if (sample.damaged++ == 0) sample.first_damaged = lines->number();
    if (auto passed = lines->recover(); !passed) return failure(passed.error());
  }
  return all;
}

/// Removes and returns the lines that look like comments. The last one before the rows may be a header.
std::vector<Line> take_comments(std::vector<Line>& lines, TableSample& sample) {
  for (const char* mark : {"#", "%", "//"})
    if (sample.comment.empty() && !lines.empty() && lines.front().text.starts_with(mark)) sample.comment = mark;
  std::vector<Line> comments;
  if (sample.comment.empty()) return comments;
  const auto is_comment = [&](const Line& line) { return line.text.starts_with(sample.comment); };
  std::ranges::copy_if(lines, std::back_inserter(comments), is_comment);
  std::erase_if(lines, is_comment);
  return comments;
}

/// Returns lines from the whole sample; a subset if there are many.
std::vector<const Line*> pick_lines(const std::vector<Line>& lines) {
  constexpr std::size_t kMaxPickedLines = 600;
  const std::size_t step = lines.size() / kMaxPickedLines + 1;
  std::vector<const Line*> some;
  for (std::size_t i = 0; i < lines.size(); i += step) some.push_back(&lines[i]);
  if (!lines.empty() && some.back() != &lines.back()) some.push_back(&lines.back());
  return some;
}

struct Shape {
  char separator = ',';
  std::size_t width{};
  std::size_t equal_lines{};
  /// The number of fields of a row, including those that are empty at the end of every row.
  std::size_t fields{};
};

/// Finds the separator that divides most lines into an equal number of fields, with values among them. The order of
/// candidates matters: a comma may be a decimal sign, and a blank may separate a date from its time.
Shape find_shape(const std::vector<Line>& lines) {
  constexpr std::array<char, 4> kInOrder{'\t', ';', ',', ' '};
  Shape best{.separator = '\0'};
  const auto some = pick_lines(lines);
  for (const char separator : kInOrder) {
    struct Widths {
      std::size_t count{}, filled{};
    };
    std::map<std::size_t, Widths> widths;
    for (const Line* line : some) {
      const auto fields = split_fields(line->text, separator);
      if (!fields || count_values(*fields) == 0) continue;
      auto& [count, filled] = widths[fields->size()];
      ++count;
      filled = std::max(filled, filled_width(*fields));
    }
    for (const auto& [fields, width] : widths) {
      const std::size_t needed =
          separator == best.separator ? best.equal_lines : best.equal_lines + best.equal_lines / 10 + 1;
      if (width.filled >= 2 && width.count >= needed) best = {separator, width.filled, width.count, fields};
    }
  }
  return best;
}

/// Returns, for each column, whether most lines have a value in the column.
std::vector<bool> value_columns(const std::vector<Line>& lines, const Shape& shape) {
  std::vector<std::size_t> counts(shape.width);
  std::size_t all = 0;
  for (const Line* line : pick_lines(lines)) {
    const auto fields = split_fields(line->text, shape.separator);
    if (!fields || fields->size() < shape.width || filled_width(*fields) > shape.width) continue;
    ++all;
    for (std::size_t i = 0; i < shape.width; ++i) counts[i] += is_value((*fields)[i]) ? 1 : 0;
  }
  std::vector<bool> are(shape.width);
  for (std::size_t i = 0; i < shape.width; ++i) are[i] = 2 * counts[i] >= all && counts[i] > 0;
  return are;
}

bool is_row(const Fields& fields, const std::vector<bool>& values) {
  if (filled_width(fields) > values.size() || fields.size() < values.size()) return false;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] && is_value(fields[i])) return true;
  return false;
}

/// Returns whether a line has only texts, which could be the names or units of the columns. Such a line may also name
/// columns that are empty in every row.
bool is_text_line(const Fields& fields, const std::vector<bool>& values, const Shape& shape) {
  constexpr std::size_t kMaxExtraFields = 2;
  const std::size_t widest = std::max(shape.width, shape.fields) + kMaxExtraFields;
  if (fields.size() < values.size() || filled_width(fields) > widest) return false;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] && is_value(fields[i])) return false;
  return true;
}

/// Returns whether most fields have a text. A spreadsheet fills up a title line with empty fields.
bool is_full(const Fields& fields, std::size_t width) {
  const auto filled = std::ranges::count_if(fields, [](const std::string& field) { return !field.empty(); });
  return 4 * static_cast<std::size_t>(filled) >= 3 * width;
}

/// Returns a unit without the brackets around it.
std::string remove_brackets(const std::string& unit) {
  return unit.size() > 2 && unit.find_first_of("[(") == 0 ? unit.substr(1, unit.size() - 2) : unit;
}

/// Returns whether a text is a unit of time, temperature or rate.
bool is_unit(const std::string& text) {
  constexpr std::array<std::string_view, 7> kTimes{"ns", "us", "ms", "s", "min", "h", "d"};
  const auto named = "x [" + text + "]";
  return celsius_scale(text) || degrees_per_hour_in(named) ||
         std::ranges::find(kTimes, time_unit_in(named)) != kTimes.end();
}

/// Finds the names of the columns, and the lines before the rows that a map must skip.
class HeaderSearch {
 public:
  HeaderSearch(const std::vector<Line>& lines, const std::vector<Line>& comments, const Shape& shape,
               const std::vector<bool>& values, std::size_t first, TableSample& sample)
      : lines_(lines), comments_(comments), shape_(shape), values_(values), first_(first), sample_(sample) {}

  void find() {
    if (const auto names = find_name_line()) return take_names(*names);
    number_columns();
    if (take_multiline_header() || take_comment_names()) return;
    sample_.names.assign(shape_.width, "");
  }

 private:
  /// Examines up to five consecutive text lines directly above the rows. Returns the topmost one that is full, and
  /// prefers one that is not wider than the rows.
  std::optional<std::size_t> find_name_line() const {
    constexpr std::size_t kMaxLinesAbove = 5;
    std::optional<std::size_t> names, wider;
    for (std::size_t i = first_; i-- > 0 && first_ - i <= kMaxLinesAbove;) {
      const auto fields = split_fields(lines_[i].text, shape_.separator);
      if (!fields || fields->front() == "TOA5" || !is_text_line(*fields, values_, shape_)) break;
      if (!is_full(*fields, shape_.width)) continue;
      (filled_width(*fields) <= std::max(shape_.width, shape_.fields) ? names : wider) = i;
    }
    return names ? names : wider;
  }

  void take_names(std::size_t at) {
    sample_.names = *split_fields(lines_[at].text, shape_.separator);
    const bool fits = filled_width(sample_.names) <= std::max(shape_.width, shape_.fields);
    sample_.names.resize(shape_.width);
    if (!fits) return number_columns();  // rows have fewer fields
    if (at > 0) sample_.preamble = lines_[at].number - 1;
    sample_.skip = lines_[first_].number - lines_[at].number - 1 - comments_between(lines_[at].number);
    take_units(at);
  }

  /// Takes the line of units between the names and the rows, if there is one.
  void take_units(std::size_t names) {
    for (std::size_t i = names + 1; i < first_; ++i) {
      auto fields = split_fields(lines_[i].text, shape_.separator);
      if (!fields) continue;
      std::ranges::transform(*fields, fields->begin(), remove_brackets);
      const auto known = std::ranges::count_if(*fields, is_unit);
      const auto filled = std::ranges::count_if(*fields, [](const std::string& field) { return !field.empty(); });
      if (known == 0 || 2 * known < filled) continue;
      fields->resize(shape_.width);
      sample_.header_units = std::move(*fields);
      return;
    }
  }

  std::size_t comments_between(std::size_t from) const {
    return static_cast<std::size_t>(std::ranges::count_if(comments_, [&](const Line& comment) {
      return comment.number > from && comment.number < lines_[first_].number;
    }));
  }

  void number_columns() {
    sample_.header = false;
    sample_.preamble = 0;
    sample_.skip = first_ == 0 ? 0 : lines_[first_].number - 1 - comments_between(0);
  }

  /// Finds a header with line ends inside quoted names.
  bool take_multiline_header() {
    constexpr std::size_t kMaxHeaderLines = 20;
    std::string joined;
    for (std::size_t i = first_; i-- > 0 && first_ - i <= kMaxHeaderLines;) {
      joined.insert(0, lines_[i].text + (joined.empty() ? "" : " "));
      const auto fields = split_fields(joined, shape_.separator);
      if (!fields || fields->size() != shape_.width || !is_text_line(*fields, values_, shape_)) continue;
      sample_.names = *fields;
      return true;
    }
    return false;
  }

  /// Finds a header in a comment, as numpy writes it.
  bool take_comment_names() {
    for (auto comment = comments_.rbegin(); comment != comments_.rend(); ++comment) {
      if (comment->number > lines_[first_].number) continue;
      const auto fields =
          split_fields(std::string(trimmed(comment->text.substr(sample_.comment.size()))), shape_.separator);
      if (!fields || fields->size() != shape_.width || !is_text_line(*fields, values_, shape_)) return false;
      const auto has_meaning = [](const std::string& name) {
        return is_time_name(name) || is_temperature_name(name) || is_gyro_name(name);
      };
      if (std::ranges::none_of(*fields, has_meaning)) return false;  // an ordinary comment
      sample_.names = *fields;
      return true;
    }
    return false;
  }

  const std::vector<Line>& lines_;
  const std::vector<Line>& comments_;
  const Shape& shape_;
  const std::vector<bool>& values_;
  std::size_t first_;
  TableSample& sample_;
};

/// The evidence for separators of thousands in a table: "1,234,567", "1.234,5", and numbers below a thousand next to
/// "1,234".
struct MarkCounts {
  /// Fields in which the mark can only be a decimal sign.
  std::size_t decimal{};
  /// Fields in which it can only be a separator of thousands.
  std::size_t thousands{};
  /// Fields in which it can be either: "1,234".
  std::size_t either{};
};

MarkCounts count_marks(const TableSample& sample, const std::vector<bool>& values, char mark) {
  MarkCounts marks;
  for (const Fields& row : sample.rows)
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string& field = row[i];
      const auto count = std::ranges::count(field, mark);
      if (!values[i] || count == 0 || field.find(':') != std::string::npos || !is_value(field)) continue;
      const char other = mark == ',' ? '.' : ',';
      const auto number = std::string_view(field).substr(0, field.size() - unit_behind_number(field).size());
      const bool may_be_thousands = has_good_thousands(trimmed(number), mark, other) && !number.starts_with('0');
      const auto last = number.rfind(mark);
      const bool has_other = number.find(other) != std::string_view::npos;
      const bool is_behind_other = has_other && number.rfind(other) < last;
      const bool can_be_decimal = is_behind_other || (count == 1 && !has_other);
      if (can_be_decimal && (is_behind_other || !may_be_thousands))
        ++marks.decimal;
      else if (can_be_decimal)
        ++marks.either;
      else if (may_be_thousands)
        ++marks.thousands;
    }
  return marks;
}

/// Returns the sum of a column's absolute steps divided by the column's range. The result is large if a wrong notation
/// makes the numbers jump by a factor of a thousand.
double roughness(const TableSample& sample, std::size_t column) {
  const auto numbers = sample.column_numbers(column);
  if (numbers.size() < 3) return 0;
  const auto [least, greatest] = std::ranges::minmax_element(numbers);
  const double range = *greatest - *least;
  double sum = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) sum += std::abs(numbers[i] - numbers[i - 1]);
  return range > 0 ? sum / range : 0;
}

/// Returns whether numbers such as "998", "1,000", "1,001" form a smoother series if the mark separates thousands than
/// if it is a decimal sign.
bool is_smoother_as_thousands(TableSample& sample, const std::vector<bool>& values, char mark) {
  const NumberStyle before = sample.style;
  const auto total = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i]) sum += roughness(sample, i);
    return sum;
  };
  sample.style = {mark == ',' ? '.' : ',', mark, before.units};
  const double as_thousands = total();
  sample.style = {mark, '\0', before.units};
  const double as_decimals = total();
  sample.style = before;
  return as_thousands < as_decimals;
}

bool has_plain_whole_numbers(const TableSample& sample, const std::vector<bool>& values, char mark) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::size_t with = 0, without = 0;
    for (const Fields& row : sample.rows) {
      if (!values[i] || !is_value(row[i])) continue;
      (row[i].find(mark) != std::string::npos ? with : without) += 1;
    }
    if (with > 0 && without > 0) return true;
  }
  return false;
}

void find_number_style(TableSample& sample, const std::vector<bool>& values) {
  const MarkCounts commas = count_marks(sample, values, ','), points = count_marks(sample, values, '.');
  NumberStyle& style = sample.style;
  const bool comma_is_decimal = sample.separator != ',' && commas.decimal > points.decimal && commas.thousands == 0;
  if (comma_is_decimal) {
    style.decimal = ',';
    if (points.thousands > 0 || (points.either > 0 && points.decimal == 0)) style.thousands = '.';
  } else if (commas.thousands > 0 || (commas.either > 0 && (points.decimal > 0 || sample.separator == ','))) {
    style.thousands = commas.decimal == 0 ? ',' : '\0';
  } else if (commas.either > 0) {  // only marks like "1,234"
    const bool leaps = has_plain_whole_numbers(sample, values, ',') && is_smoother_as_thousands(sample, values, ',');
    if (leaps)
      style.thousands = ',';
    else
      style.decimal = ',';
    sample.is_decimal_doubtful = !leaps && has_plain_whole_numbers(sample, values, ',');
  }
  for (const char mark : {' ', '\''}) {
    if (style.thousands != 0 || sample.separator == mark) continue;
    const auto is_marked = [&](const std::string& field) {
      return field.find(mark) != std::string::npos && has_digit(field.substr(0, 1)) &&
             has_good_thousands(field, mark, style.decimal) &&
             field.find_first_not_of(std::string("0123456789.,-+") + mark) == std::string::npos;
    };
    if (std::ranges::any_of(sample.rows, [&](const Fields& row) { return std::ranges::any_of(row, is_marked); }))
      style.thousands = mark;
  }
}

/// Finds the texts that follow the numbers of a column.
void find_cell_units(TableSample& sample, const std::vector<bool>& values) {
  sample.cell_units.assign(values.size(), "");
  std::set<std::string> units;
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::map<std::string, std::size_t> counts;
    for (const Fields& row : sample.rows)
      if (const auto unit = unit_behind_number(row[i]);
          values[i] && !unit.empty() && !parse_clock(row[i]) && !looks_like_time(row[i]))
        ++counts[std::string(unit)];
    for (const auto& [unit, count] : counts)
      if (2 * count >= sample.rows.size()) {
        sample.cell_units[i] = unit;
        units.insert(unit);
      }
  }
  sample.style.units.assign(units.begin(), units.end());
}

/// Returns whether a text in a number column may mark a missing value: it has no digit, or contains "#" as in "#DIV/0!"
/// of spreadsheets and "1.#QNAN" of C.
bool may_be_missing(const std::string& text) { return !has_digit(text) || text.find('#') != std::string::npos; }

/// Keeps the rows that can be read, and collects the texts that mark missing values.
void keep_good_rows(TableSample& sample, const std::vector<std::size_t>& numbers) {
  constexpr std::size_t kMaxTexts = 8;
  std::set<std::size_t> numeric;
  for (std::size_t i = 0; i < sample.names.size(); ++i)
    if (!sample.column_numbers(i).empty()) numeric.insert(i);
  std::map<std::string, std::size_t> texts;
  std::vector<Fields> good;
  for (std::size_t row = 0; row < sample.rows.size(); ++row) {
    Fields& fields = sample.rows[row];
    bool is_good = fields != sample.names;
    for (const std::size_t i : numeric)
      is_good = is_good && (sample.number_in_field(fields[i]) || may_be_missing(fields[i]));
    if (!is_good) {
      if (sample.damaged++ == 0 || numbers[row] < sample.first_damaged) sample.first_damaged = numbers[row];
      continue;
    }
    for (const std::size_t i : numeric)
      if (!sample.number_in_field(fields[i])) ++texts[fields[i]];
    good.push_back(std::move(fields));
  }
  sample.rows = std::move(good);
  std::vector<std::pair<std::size_t, std::string>> by_count;
  for (const auto& [text, count] : texts) by_count.emplace_back(count, text);
  std::ranges::sort(by_count, std::greater<>());
  for (std::size_t i = 0; i < std::min(by_count.size(), kMaxTexts); ++i) sample.missing.push_back(by_count[i].second);
  std::ranges::sort(sample.missing);
}

/// Adds the rows of a LabVIEW measurement file to an empty sample. Rows may lack the column "Comment". Returns nothing
/// if the lines are not such a file, or none of its rows can be read.
std::optional<TableSample> sample_lvm(const std::vector<Line>& lines, TableSample sample) {
  std::vector<std::string_view> texts;
  for (const Line& line : lines) texts.emplace_back(line.text);
  const auto layout = find_lvm_layout(texts);
  if (!layout) return std::nullopt;
  const auto names = split_fields(lines[layout->names].text, layout->separator);
  if (!names || names->size() < 2) return std::nullopt;
  sample.is_lvm = true;
  sample.separator = layout->separator;
  sample.names = *names;
  sample.header_units = layout->units;
  sample.header_units.resize(names->size());
  sample.cell_units.assign(names->size(), "");
  sample.preamble = lines[layout->names].number - 1;
  sample.style.decimal = layout->decimal;
  sample.spacing_s = layout->spacing_s;
  std::vector<std::size_t> numbers;
  for (const std::size_t row : layout->rows) {
    auto fields = split_fields(lines[row].text, layout->separator);
    const bool fits = fields && fields->size() + 1 >= names->size() && filled_width(*fields) <= names->size();
    if (!fits) {
      if (sample.damaged++ == 0) sample.first_damaged = lines[row].number;
      continue;
    }
    fields->resize(names->size());
    sample.rows.push_back(std::move(*fields));
    numbers.push_back(lines[row].number);
  }
  keep_good_rows(sample, numbers);
  return sample.rows.empty() ? std::nullopt : std::optional(std::move(sample));
}

}  // namespace

std::optional<double> TableSample::number_in_field(const std::string& field) const {
  std::string changed;
  return record::number_in(style.normalise(field, changed));
}

std::vector<double> TableSample::column_numbers(std::size_t column) const {
  std::vector<double> numbers;
  for (const auto& row : rows)
    if (const auto number = number_in_field(row[column])) numbers.push_back(*number);
  return 2 * numbers.size() >= rows.size() ? numbers : std::vector<double>{};
}

bool TableSample::needs_column_number(std::size_t column) const {
  return !header || names[column].empty() || std::ranges::count(names, names[column]) > 1;
}

std::string TableSample::column_name(std::size_t column) const {
  std::string name = names[column].empty() ? std::to_string(column + 1) : names[column];
  const auto& unit = cell_units[column].empty() && !header_units.empty() ? header_units[column] : cell_units[column];
  if (!unit.empty() && name.find_first_of("[(") == std::string::npos) name += " [" + unit + "]";
  return name;
}

std::string toml_text(std::string_view text) { return toml_quoted(plain(text)); }

std::string TableSample::reference(std::size_t column, const std::string& key) const {
  const std::string& name = names[column];
  if (!needs_column_number(column)) return fmt::format("{} = {}", key, toml_text(name));
  const auto behind = name.empty() ? std::string() : "        # " + toml_text(name);
  return fmt::format("{}{} = {}{}", key, header ? "_number" : "", column + 1, behind);
}

Result<TableSample> sample_table(Bytes bytes) {
  const std::string file = bytes.name();
  const auto no_table = [&] {
    return failure(FaultKind::bad_file, file, "neither a text table of at least two columns nor a known log format");
  };
  TableSample sample;
  auto lines = read_sample_lines(std::move(bytes), sample);
  if (!lines) return failure(lines.error());
  if (auto lvm = sample_lvm(*lines, sample)) return std::move(*lvm);
  const auto comments = take_comments(*lines, sample);
  for (const Line& comment : comments)
    sample.comments.emplace_back(trimmed(comment.text.substr(sample.comment.size())));
  const Shape shape = find_shape(*lines);
  if (shape.width < 2) return no_table();
  sample.separator = shape.separator;
  const auto values = value_columns(*lines, shape);
  std::optional<std::size_t> first;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < lines->size(); ++i) {
    auto fields = split_fields((*lines)[i].text, shape.separator);
    if (fields && is_row(*fields, values)) {
      if (!first) first = i;
      fields->resize(shape.width);
      sample.rows.push_back(std::move(*fields));
      numbers.push_back((*lines)[i].number);
    } else if (first && sample.damaged++ == 0) {
      sample.first_damaged = (*lines)[i].number;
    }
  }
  if (!first) return no_table();
  sample.cell_units.assign(shape.width, "");
  HeaderSearch(*lines, comments, shape, values, *first, sample).find();
  find_cell_units(sample, values);
  find_number_style(sample, values);
  keep_good_rows(sample, numbers);
  return sample.rows.empty() ? Result<TableSample>(no_table()) : sample;
}

}  // namespace gyrotherm::exchange
