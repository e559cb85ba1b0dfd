// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/text_template.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/text.hpp"

namespace gyrotherm::drivers {
namespace {

constexpr std::ptrdiff_t kLongestNumber = 40;
constexpr int kWidestField = 64, kLongestList = 64, kMostDecimals = 9;
/// Largest integer that a double holds exactly.
constexpr std::int64_t kLargestInteger = std::int64_t{1} << 53;
/// Steps of one match, against templates whose texts and groups fit in very many ways.
constexpr int kMostSteps = 200'000;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

tl::unexpected<Fault> template_fault(std::string what) { return failure(FaultKind::bad_file, "", std::move(what)); }

/// Reads digits at the start of `text` and removes them. Returns nothing if there are none or the number is too large.
std::optional<int> take_number(std::string_view& text, int most) {
  if (text.empty() || !is_digit(text.front())) return std::nullopt;  // no sign
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || value > most) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// Reads "*8,": the count and the separator of a list.
bool take_list(std::string_view& text, FieldForm& form) {
  if (!text.starts_with('*')) return true;
  text.remove_prefix(1);
  const auto count = take_number(text, kLongestList);
  if (!count || *count == 0) return false;
  form.count = *count;
  if (text.empty()) return true;
  form.separator = text.front();
  text.remove_prefix(1);
  return true;
}

std::optional<FieldForm> parse_form(std::string_view text) {
  if (text.empty()) return std::nullopt;
  FieldForm form;
  if (text.starts_with('+')) {
    form.has_sign = true;
    text.remove_prefix(1);
    if (text.empty() || (text.front() != 'd' && text.front() != 'f')) return std::nullopt;
  }
  const char kind = text.front();
  text.remove_prefix(1);
  switch (kind) {
    case 'f': form.kind = FieldForm::Kind::number; break;
    case 'd': form.kind = FieldForm::Kind::integer; break;
    case 'x':
    case 'u':
      form.kind = FieldForm::Kind::hexadecimal;
      form.is_unsigned = kind == 'u';
      break;
    case 's': form.kind = FieldForm::Kind::text; break;
    case 'b': form.kind = FieldForm::Kind::bits; break;
    default: return std::nullopt;
  }
  if (!text.empty() && is_digit(text.front())) {
    const auto width = take_number(text, kWidestField);
    if (!width || (form.kind == FieldForm::Kind::text && *width == 0)) return std::nullopt;
    form.width = *width;
  }
  if (text.starts_with('.')) {
    text.remove_prefix(1);
    const auto decimals = take_number(text, kMostDecimals);
    if (!decimals || form.kind != FieldForm::Kind::number) return std::nullopt;
    form.decimals = *decimals;
  }
  const bool is_list_kind = form.kind == FieldForm::Kind::number || form.kind == FieldForm::Kind::integer;
  if (!is_list_kind && text.starts_with('*')) return std::nullopt;
  if (!take_list(text, form) || !text.empty()) return std::nullopt;
  const bool needs_width = form.kind == FieldForm::Kind::hexadecimal || form.kind == FieldForm::Kind::bits;
  constexpr int kMostHexDigits = 8;
  if (needs_width && form.width == 0) return std::nullopt;
  if (form.kind == FieldForm::Kind::hexadecimal && form.width > kMostHexDigits) return std::nullopt;
  return form;
}

std::string format_number(const FieldForm& form, double value) {
  if (!std::isfinite(value)) value = 0;
  if (form.kind == FieldForm::Kind::integer || form.decimals == 0) value = std::round(value);
  if (value == 0) value = 0;  // no minus sign
  const auto write = [&form](double number) {
    const int decimals = form.kind == FieldForm::Kind::integer ? 0 : form.decimals;
    if (decimals < 0) return form.has_sign ? fmt::format("{:+.10g}", number) : fmt::format("{:.10g}", number);
    return form.has_sign ? fmt::format("{:+0{}.{}f}", number, form.width, decimals)
                         : fmt::format("{:0{}.{}f}", number, form.width, decimals);
  };
  auto text = write(value);
  // A value that rounds to zero keeps no minus sign either.
  const bool is_zero = text.starts_with('-') && text.find_first_not_of("-0.") == std::string::npos;
  return is_zero ? write(0.0) : text;
}

std::string format_hexadecimal(int width, double value) {
  constexpr int kBitsPerDigit = 4;
  const auto modulus = std::uint64_t{1} << (width * kBitsPerDigit);
  const bool is_in_range = std::abs(value) <= static_cast<double>(kLargestInteger);  // false for NaN
  const auto number = static_cast<std::uint64_t>(static_cast<std::int64_t>(is_in_range ? std::round(value) : 0));
  return fmt::format("{:0{}X}", number & (modulus - 1), width);
}

}  // namespace

std::string format_field(const FieldForm& form, const FieldValue& value) {
  if (const auto* list = std::get_if<std::vector<double>>(&value)) {
    std::vector<std::string> all;
    for (const double one : *list) all.push_back(format_number(form, one));
    return fmt::format("{}", fmt::join(all, std::string(1, form.separator)));
  }
  if (const auto* text = std::get_if<std::string>(&value)) {
    if (form.kind != FieldForm::Kind::bits) return *text;
    auto digits = *text;
    digits.resize(static_cast<std::size_t>(form.width), '0');
    return digits;
  }
  const double number = std::get<double>(value);
  switch (form.kind) {
    case FieldForm::Kind::hexadecimal: return format_hexadecimal(form.width, number);
    case FieldForm::Kind::text: return fmt::format("{:.10g}", number);
    case FieldForm::Kind::bits: {
      std::string digits(static_cast<std::size_t>(form.width), '0');
      if (number != 0) digits.back() = '1';
      return digits;
    }
    default: return format_number(form, number);
  }
}

Result<std::string> to_encoding(std::string_view text, TextEncoding encoding) {
  constexpr unsigned kLastAscii = 0x7F, kLastLatin1 = 0xFF;
  constexpr unsigned kTwoByteMark = 0x1F, kContinuationMark = 0x3F;
  constexpr int kContinuationBits = 6;
  std::string bytes;
  while (!text.empty()) {
    const auto size = character_size(text);
    const auto first = static_cast<unsigned char>(text.front());
    unsigned code = first;
    if (size == 2)
      code = (first & kTwoByteMark) << kContinuationBits | (static_cast<unsigned char>(text[1]) & kContinuationMark);
    const bool fits = size == 1 || (size == 2 && encoding == TextEncoding::latin1 && code <= kLastLatin1);
    if (!fits || (encoding == TextEncoding::ascii && code > kLastAscii))
      return template_fault(fmt::format("\"{}\" is not a character of the encoding {}",
                                        plain(text.substr(0, std::max<std::size_t>(size, 1))),
                                        encoding == TextEncoding::ascii ? "ascii" : "latin1"));
    bytes.push_back(static_cast<char>(code));
    text.remove_prefix(size);
  }
  return bytes;
}

/// Recursive-descent parser of a template's text.
class TextTemplate::Parser {
 public:
  Parser(std::string_view text, TextTemplate& target) : text_(text), target_(target) {}

  Result<void> parse() {
    auto pieces = parse_pieces(false);
    if (!pieces) return failure(std::move(pieces.error()));
    target_.pieces_ = std::move(*pieces);
    return mark_columns(target_.pieces_, {});
  }

 private:
  /// Marks each number that a field or digit may follow, in these pieces and in their groups. `after` are the pieces
  /// after a group.
  Result<void> mark_columns(std::span<const Piece> pieces, std::span<const Piece> after) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const auto next = pieces.subspan(i + 1);
      if (auto marked = mark_columns(pieces[i].group, next); !marked) return marked;
      if (!pieces[i].field) continue;
      auto& [name, form] = target_.fields_[*pieces[i].field];
      const bool is_number = form.kind == FieldForm::Kind::number || form.kind == FieldForm::Kind::integer;
      if (!is_number || !(follows_number(next, form) || (can_end(next) && follows_number(after, form)))) continue;
      if (form.width == 0)
        return template_fault(
            fmt::format("the end of the number {{{0}}} cannot be found, because a field or digit follows it; give it a "
                        "width, as in {{{0}:d3}} or {{{0}:f05.1}}, or give the number after it a sign, as in "
                        "{{value:+d}}",
                        plain(name)));
      form.is_exact = true;
    }
    return {};
  }

  /// Returns whether these pieces may be left out.
  static bool can_end(std::span<const Piece> pieces) {
    return std::ranges::all_of(pieces, [](const Piece& piece) { return !piece.group.empty(); });
  }

  /// Returns whether these pieces may begin with a digit, or with a text of a fixed width after a number with a width.
  [[nodiscard]] bool follows_number(std::span<const Piece> pieces, const FieldForm& number) const {
    for (const auto& piece : pieces) {
      if (!piece.group.empty()) {
        if (follows_number(piece.group, number)) return true;
        continue;
      }
      if (!piece.field) return is_digit(piece.literal.front());
      const auto& form = target_.fields_[*piece.field].form;
      return form.kind == FieldForm::Kind::text ? form.width > 0 && number.width > 0 : !form.has_sign;
    }
    return false;
  }

  /// Parses up to the end, or in a group up to its "]".
  Result<std::vector<Piece>> parse_pieces(bool in_group) {
    std::vector<Piece> pieces;
    while (!text_.empty()) {
      const char c = text_.front();
      const bool is_doubled = text_.size() > 1 && text_[1] == c;
      if (c == ']' && in_group) return pieces;
      if ((c == '{' || c == '[') && !is_doubled) {
        auto piece = c == '{' ? parse_field() : parse_group(in_group);
        if (!piece) return failure(std::move(piece.error()));
        if (!pieces.empty() && is_open_text(pieces.back()) && is_text(*piece))
          return template_fault(
              "two texts follow each other without a literal; give the first one a width, as in {value:s4}");
        pieces.push_back(std::move(*piece));
        continue;
      }
      if (pieces.empty() || pieces.back().literal.empty()) pieces.emplace_back();
      pieces.back().literal.push_back(c);
      text_.remove_prefix((c == '{' || c == '[') && is_doubled ? 2 : 1);
    }
    if (in_group) return template_fault("\"[\" is not closed by \"]\"");
    return pieces;
  }

  [[nodiscard]] bool is_text(const Piece& piece) const {
    return piece.field && target_.fields_[*piece.field].form.kind == FieldForm::Kind::text;
  }

  /// Returns whether a piece is a text without a width.
  [[nodiscard]] bool is_open_text(const Piece& piece) const {
    return is_text(piece) && target_.fields_[*piece.field].form.width == 0;
  }

  Result<Piece> parse_group(bool in_group) {
    if (in_group) return template_fault("an optional group is inside another");
    text_.remove_prefix(1);
    auto pieces = parse_pieces(true);
    if (!pieces) return failure(std::move(pieces.error()));
    text_.remove_prefix(1);
    if (pieces->empty()) return template_fault("an optional group is empty");
    Piece piece;
    piece.group = std::move(*pieces);
    return piece;
  }

  Result<Piece> parse_field() {
    const auto end = text_.find('}');
    if (end == std::string_view::npos) return template_fault("\"{\" is not closed by \"}\"");
    const auto content = text_.substr(1, end - 1);
    text_.remove_prefix(end + 1);
    const auto colon = content.find(':');
    const auto name = content.substr(0, colon);
    const auto form = colon == std::string_view::npos ? std::nullopt : parse_form(content.substr(colon + 1));
    if (name.empty() || !form)
      return template_fault(
          fmt::format("\"{{{}}}\" is not a field, expected a name and a form such as {{value:f.1}}, {{value:d}}, "
                      "{{value:x4}}, {{value:s}} or {{value:b32}}",
                      plain(content)));
    if (name != "_" && target_.find(name)) return template_fault(fmt::format("the field \"{}\" occurs twice", name));
    Piece piece;
    piece.field = target_.fields_.size();
    target_.fields_.push_back({std::string(name), *form});
    return piece;
  }

  std::string_view text_;
  TextTemplate& target_;
};

Result<TextTemplate> TextTemplate::parse(std::string_view text, TextEncoding encoding) {
  const auto bytes = to_encoding(text, encoding);
  if (!bytes) return failure(bytes.error());
  TextTemplate made;
  if (auto parsed = Parser(*bytes, made).parse(); !parsed) return failure(std::move(parsed.error()));
  return made;
}

const TextTemplate::Field* TextTemplate::find(std::string_view field) const {
  const auto found = std::ranges::find(fields_, field, &Field::name);
  return found == fields_.end() ? nullptr : &*found;
}

void TextTemplate::remove_sign(std::string_view field) {
  const auto found = std::ranges::find(fields_, field, &Field::name);
  if (found != fields_.end() && found->form.kind == FieldForm::Kind::hexadecimal) found->form.is_unsigned = true;
}

bool TextTemplate::can_format(const FieldValues& values) const {
  constexpr int kBitsPerDigit = 4;
  return std::ranges::all_of(fields_, [&](const Field& field) {
    const auto found = values.find(field.name);
    const auto* number = found == values.end() ? nullptr : std::get_if<double>(&found->second);
    if (!number) return true;
    const auto& form = field.form;
    if (form.is_exact) return format_field(form, *number).size() == static_cast<std::size_t>(form.width);
    if (form.kind != FieldForm::Kind::hexadecimal) return true;
    const double value_count = std::exp2(kBitsPerDigit * form.width), rounded = std::round(*number);
    return form.is_unsigned ? rounded >= 0 && rounded < value_count
                            : rounded >= -value_count / 2 && rounded < value_count / 2;
  });
}

bool TextTemplate::has_value(const std::vector<Piece>& pieces, const FieldValues& values) const {
  return std::ranges::any_of(
      pieces, [&](const Piece& piece) { return piece.field && values.contains(fields_[*piece.field].name); });
}

void TextTemplate::format_pieces(const std::vector<Piece>& pieces, const FieldValues& values, std::string& line) const {
  for (const auto& piece : pieces) {
    line += piece.literal;
    if (!piece.group.empty() && has_value(piece.group, values)) format_pieces(piece.group, values, line);
    if (!piece.field) continue;
    const auto& field = fields_[*piece.field];
    const auto found = values.find(field.name);
    const bool is_text = field.form.kind == FieldForm::Kind::text;
    if (found != values.end())
      line += format_field(field.form, found->second);
    else if (!is_text)
      line += format_field(field.form, 0.0);
  }
}

std::string TextTemplate::format(const FieldValues& values) const {
  std::string line;
  format_pieces(pieces_, values, line);
  return line;
}

/// A line may end with each of the groups at the end of its template, and with the piece before them.
bool TextTemplate::end_with_open_number(std::span<const Piece> pieces) const {
  for (; !pieces.empty(); pieces = pieces.first(pieces.size() - 1)) {
    const auto& last = pieces.back();
    if (last.group.empty()) {
      if (!last.field) return false;
      const auto& form = fields_[*last.field].form;
      if (form.is_exact) return false;
      return form.kind == FieldForm::Kind::integer || (form.kind == FieldForm::Kind::number && form.decimals <= 0);
    }
    if (end_with_open_number(last.group)) return true;
  }
  return false;
}

bool TextTemplate::ends_with_open_number() const { return end_with_open_number(pieces_); }

std::string TextTemplate::prefix() const { return pieces_.empty() ? "" : pieces_.front().literal; }

/// Backtracking matcher of one line.
class TextTemplate::Matcher {
 public:
  Matcher(const TextTemplate& form, std::string_view line, NumberCheck check)
      : form_(form), line_(line), check_(check) {}

  std::optional<FieldValues> match() {
    std::vector<const Piece*> pieces;
    for (const auto& piece : form_.pieces_) pieces.push_back(&piece);
    if (!match_from(pieces, 0, 0)) return std::nullopt;
    return std::move(values_);
  }

 private:
  /// Matches the pieces from `index` on with the line from `at` on.
  bool match_from(const std::vector<const Piece*>& pieces, std::size_t index, std::size_t at) {
    if (++steps_ > kMostSteps) return false;
    if (index == pieces.size()) return at == line_.size();
    const auto& piece = *pieces[index];
    if (!piece.group.empty()) return match_group(pieces, index, at);
    if (!piece.field) {
      const auto end = skip_literal(piece.literal, at);
      return end && match_from(pieces, index + 1, *end);
    }
    const auto& field = form_.fields_[*piece.field];
    if (field.form.kind == FieldForm::Kind::text) return match_text(pieces, index, at, field);
    auto end = at;
    auto value = take_value(field.form, end);
    if (!value || !match_from(pieces, index + 1, end)) return false;
    store(field, std::move(*value));
    return true;
  }

  bool match_group(const std::vector<const Piece*>& pieces, std::size_t index, std::size_t at) {
    std::vector<const Piece*> with_group;
    for (const auto& one : pieces[index]->group) with_group.push_back(&one);
    with_group.insert(with_group.end(), pieces.begin() + static_cast<std::ptrdiff_t>(index) + 1, pieces.end());
    return match_from(with_group, 0, at) || match_from(pieces, index + 1, at);
  }

  /// Tries the shortest text first.
  bool match_text(const std::vector<const Piece*>& pieces, std::size_t index, std::size_t at, const Field& field) {
    const bool is_last = index + 1 == pieces.size();
    const auto width = static_cast<std::size_t>(field.form.width);
    const auto shortest = width > 0 ? at + width : is_last ? line_.size() : at;
    const auto longest = width > 0 ? at + width : line_.size();
    for (std::size_t end = shortest; end <= std::min(longest, line_.size()); ++end) {
      if (!match_from(pieces, index + 1, end)) continue;
      store(field, std::string(line_.substr(at, end - at)));
      return true;
    }
    return false;
  }

  void store(const Field& field, FieldValue value) {
    if (field.name != "_") values_.insert_or_assign(field.name, std::move(value));
  }

  [[nodiscard]] std::size_t skip_blanks(std::size_t at) const {
    while (at < line_.size() && line_[at] == ' ') ++at;
    return at;
  }

  [[nodiscard]] std::optional<std::size_t> skip_literal(std::string_view literal, std::size_t at) const {
    for (const char c : literal) {
      if (c == ' ') {
        at = skip_blanks(at);
        continue;
      }
      if (at == line_.size() || line_[at] != c) return std::nullopt;
      ++at;
    }
    return at;
  }

  [[nodiscard]] std::optional<FieldValue> take_value(const FieldForm& form, std::size_t& at) const {
    const auto width = static_cast<std::size_t>(form.width);
    if (form.kind == FieldForm::Kind::bits) {
      const auto digits = line_.substr(at, width);
      if (digits.size() != width || digits.find_first_not_of("01") != std::string_view::npos) return std::nullopt;
      at += width;
      if (width == 1) return FieldValue(digits == "1" ? 1.0 : 0.0);
      return FieldValue(std::string(digits));
    }
    if (form.kind == FieldForm::Kind::hexadecimal) return take_hexadecimal(form, at);
    if (form.count == 0) {
      const auto number = take_decimal(form, at);
      return number ? std::optional<FieldValue>(*number) : std::nullopt;
    }
    std::vector<double> list;
    while (static_cast<int>(list.size()) < form.count) {
      if (!list.empty()) {
        at = form.separator == ' ' ? at : skip_blanks(at);
        if (at == line_.size() || line_[at] != form.separator) return std::nullopt;
        ++at;
      }
      const auto number = take_decimal(form, at);
      if (!number) return std::nullopt;
      list.push_back(*number);
    }
    return FieldValue(std::move(list));
  }

  /// Reads two's complement, or a number without sign.
  [[nodiscard]] std::optional<FieldValue> take_hexadecimal(const FieldForm& form, std::size_t& at) const {
    constexpr int kBase = 16, kBitsPerDigit = 4;
    const auto width = static_cast<std::size_t>(form.width);
    const auto digits = line_.substr(at, width);
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, kBase);
    if (digits.size() != width || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
    at += width;
    const auto modulus = std::int64_t{1} << (width * kBitsPerDigit);
    const auto number = static_cast<std::int64_t>(value);
    const bool is_negative = !form.is_unsigned && number >= modulus / 2;
    return FieldValue(static_cast<double>(is_negative ? number - modulus : number));
  }

  [[nodiscard]] std::optional<double> take_decimal(const FieldForm& form, std::size_t& at) const {
    const auto size = form.is_exact ? at + static_cast<std::size_t>(form.width) : line_.size();
    auto from = skip_blanks(at);
    if (size > line_.size() || from >= size) return std::nullopt;
    if (form.has_sign && line_[from] != '+' && line_[from] != '-') return std::nullopt;
    const bool has_plus = line_[from] == '+';
    if (has_plus) ++from;
    const auto first = !has_plus && line_[from] == '-' ? from + 1 : from;
    // Refuses "+-5", "inf" and "nan".
    if (first >= size || !is_digit(line_[first])) return std::nullopt;
    const auto* end = line_.data() + size;
    const auto* begin = line_.data() + from;
    double value = 0;
    const auto* stop = begin;
    if (form.kind == FieldForm::Kind::integer) {
      std::int64_t whole = 0;
      const auto [after, error] = std::from_chars(begin, end, whole);
      if (error != std::errc{} || whole > kLargestInteger || whole < -kLargestInteger) return std::nullopt;
      value = static_cast<double>(whole);
      stop = after;
    } else {
      const auto [after, error] = std::from_chars(begin, end, value);
      if (error != std::errc{}) return std::nullopt;
      stop = after;
    }
    if (form.is_exact && stop != end) return std::nullopt;
    if (stop - begin > kLongestNumber || !has_required_decimals(form, {begin, stop})) return std::nullopt;
    at = static_cast<std::size_t>(stop - line_.data());
    return value;
  }

  [[nodiscard]] bool has_required_decimals(const FieldForm& form, std::string_view number) const {
    if (check_ == NumberCheck::none || form.kind != FieldForm::Kind::number) return true;
    const auto point = number.find('.');
    if (point == std::string_view::npos) return form.decimals <= 0;
    const auto decimals = std::min(number.find_first_not_of("0123456789", point + 1), number.size()) - point - 1;
    const bool needs_all = check_ == NumberCheck::all_decimals && form.decimals > 0;
    return needs_all ? decimals == static_cast<std::size_t>(form.decimals) : decimals > 0;
  }

  const TextTemplate& form_;
  std::string_view line_;
  NumberCheck check_;
  FieldValues values_;
  int steps_ = 0;
};

std::optional<FieldValues> TextTemplate::match(std::string_view line, NumberCheck check) const {
  return Matcher(*this, line, check).match();
}

}  // namespace gyrotherm::drivers
