/// Small text files for programs that must get along without a library: a first line that names the format, then one
/// `key: value` a line in a fixed order.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/result.hpp"

namespace gyrotherm {

/// Reads such a text from its start. The first thing that is wrong is kept; everything after it is empty.
class KeyedText {
 public:
  KeyedText(std::string_view text, std::string file, std::string_view schema);

  /// The value of the next line, which has this key.
  [[nodiscard]] std::string_view text(std::string_view key);
  template <class Number>
  [[nodiscard]] Number number(std::string_view key) {
    const auto value = text(key);
    Number found{};
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), found);
    bool good = error == std::errc() && end == value.data() + value.size();
    if constexpr (std::is_floating_point_v<Number>) good = good && std::isfinite(found);
    if (!good && !wrong()) mistake(std::string(key) + ": expected a number");
    return good ? found : Number{};
  }
  [[nodiscard]] bool yes(std::string_view key);
  /// The last line's value is the length of what follows it; the text ends there.
  [[nodiscard]] std::string_view rest(std::string_view length_key);

  void mistake(std::string what);
  [[nodiscard]] bool wrong() const { return fault_.has_value(); }
  /// bad_file with file and line, or nothing. Text that is left over is a mistake too.
  [[nodiscard]] Result<void> verdict();

 private:
  [[nodiscard]] std::string_view line();

  std::string_view left_;
  std::string file_;
  int line_ = 0;
  std::optional<Fault> fault_;
};

}  // namespace gyrotherm
