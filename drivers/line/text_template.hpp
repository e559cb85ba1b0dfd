// SPDX-License-Identifier: Apache-2.0
/// Templates of the lines that a text instrument sends and receives. One template both formats and parses a line. Pure
/// functions. docs/text-instruments.md describes the syntax for authors of instrument files.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm::drivers {

/// Encoding of an instrument's text. In latin1 each character up to U+00FF is one byte.
enum class TextEncoding { ascii, latin1 };

/// Form of a field.
struct FieldForm {
  enum class Kind { number, integer, hexadecimal, text, bits };
  Kind kind{};
  /// Minimum width of a number with leading zeros, exact width if `is_exact`; exact number of hexadecimal or binary
  /// digits, or of the characters of a text; 0 for any.
  int width = 0;
  /// Decimals of a sent number; −1 sends the shortest form.
  int decimals = -1;
  /// Number of values in a list; 0 for a single value.
  int count = 0;
  char separator = ',';
  /// Hexadecimal digits are a number without sign, instead of two's complement.
  bool is_unsigned = false;
  /// A field or digit follows a number without a literal, so that only its width shows where it ends.
  bool is_exact = false;
  /// A number always has a sign, also "+".
  bool has_sign = false;
  bool operator==(const FieldForm&) const = default;
};

/// Value of a field: a number, a list of numbers, or a text.
using FieldValue = std::variant<double, std::vector<double>, std::string>;
using FieldValues = std::map<std::string, FieldValue>;

/// Required form of the numbers in a line whose field has decimals. `point` requires a decimal point with a digit after
/// it, because an error code is no temperature. `all_decimals` requires as many decimals as the field has, because the
/// end of a line without terminator may be lost.
enum class NumberCheck { none, point, all_decimals };

/// A sequence of literals, fields and optional groups.
class TextTemplate {
 public:
  struct Field {
    /// "_" for a field whose value is not used.
    std::string name;
    FieldForm form;
  };

  /// Parses a template in UTF-8. Fails with bad_file (an unclosed field or group, an unknown form, two adjacent texts,
  /// a number without width before a field or digit, a character outside `encoding`). The caller sets `where`.
  [[nodiscard]] static Result<TextTemplate> parse(std::string_view text, TextEncoding encoding);

  /// Returns all fields, including those of optional groups.
  [[nodiscard]] const std::vector<Field>& fields() const { return fields_; }
  [[nodiscard]] const Field* find(std::string_view field) const;

  /// Makes the field with this name a number without sign if it is hexadecimal.
  void remove_sign(std::string_view field);

  /// Returns whether each value has a number of characters or digits that its field can hold. A longer number would
  /// shift the fields after it, and a hexadecimal number would lose its first digits.
  [[nodiscard]] bool can_format(const FieldValues& values) const;

  /// Formats a line. A field without a value is sent as 0 or as an empty text. An optional group is sent if `values`
  /// contains one of its fields.
  [[nodiscard]] std::string format(const FieldValues& values) const;

  /// Parses a whole line. Returns nothing if it does not fit. A blank in the template fits any number of blanks.
  /// A number has a full stop as its decimal mark and may follow blanks. A text extends to the next literal that fits.
  /// No number has more than 40 characters.
  [[nodiscard]] std::optional<FieldValues> match(std::string_view line, NumberCheck check = NumberCheck::none) const;

  /// Returns whether a line may end with a number that has no fixed number of decimals, so that a line without its last
  /// digit fits too.
  [[nodiscard]] bool ends_with_open_number() const;

  /// Returns the literal text before the first field or group.
  [[nodiscard]] std::string prefix() const;

 private:
  /// One piece of a template. It is a field if `field` is set, an optional group if `group` is not empty, and otherwise
  /// a literal.
  struct Piece {
    std::string literal;
    std::optional<std::size_t> field;
    std::vector<Piece> group;
  };
  class Parser;
  class Matcher;

  void format_pieces(const std::vector<Piece>& pieces, const FieldValues& values, std::string& line) const;
  [[nodiscard]] bool has_value(const std::vector<Piece>& pieces, const FieldValues& values) const;
  [[nodiscard]] bool end_with_open_number(std::span<const Piece> pieces) const;

  std::vector<Piece> pieces_;
  std::vector<Field> fields_;
};

/// Formats one value. A number that is not finite is sent as 0.
[[nodiscard]] std::string format_field(const FieldForm& form, const FieldValue& value);

/// Converts UTF-8 to the bytes of an encoding. Fails with bad_file at a character that it does not have.
[[nodiscard]] Result<std::string> to_encoding(std::string_view text, TextEncoding encoding);

}  // namespace gyrotherm::drivers
