// SPDX-License-Identifier: Apache-2.0
/// Reads TOML and reports all errors of a file together, each with file:line:column. TomlTable reads values. The
/// functions below it read keywords, whole numbers with bounds, and files named in the text.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/quantity.hpp"
#include "core/result.hpp"
#include "core/shipped.hpp"

namespace gyrotherm {

/// One table of a TOML file. If a key is missing or has a wrong type or unit, a getter notes the error and returns a
/// neutral value. A parser therefore reads all keys and then calls verdict(). A key that no getter has read is also an
/// error ("unknown key, did you mean …"). Copies share one list of errors.
class TomlTable {
 public:
  /// Parses the text of a file; errors name it `file`. Fails with bad_file on a syntax error, or if the text exceeds a
  /// bound (toml_text.hpp).
  [[nodiscard]] static Result<TomlTable> parse(std::string_view text, std::string file);

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_table(std::string_view key) const;
  [[nodiscard]] bool is_list(std::string_view key) const;
  /// Returns whether the value is a text or a list that begins with a text.
  [[nodiscard]] bool is_text(std::string_view key) const;

  /// Reads a value. Without `fallback` the key is required.
  [[nodiscard]] double number(std::string_view key, std::optional<double> fallback = {}) const;
  [[nodiscard]] std::int64_t integer(std::string_view key, std::optional<std::int64_t> fallback = {}) const;
  [[nodiscard]] bool boolean(std::string_view key, std::optional<bool> fallback = {}) const;
  [[nodiscard]] std::string text(std::string_view key, const std::optional<std::string>& fallback = {}) const;
  /// Reads a text that must be one of `allowed`. For another text the error suggests the nearest.
  [[nodiscard]] std::string choice(std::string_view key, const std::vector<std::string>& allowed,
                                   std::string fallback = "") const;

  /// Notes an error unless the text at `key`, such as the schema of the file, equals `value`. If the file is of another
  /// kind ("gyrotherm-rig/1" instead of "gyrotherm-profile/1"), verdict() reports only this error.
  void expect(std::string_view key, std::string_view value) const;

  /// Reads a duration in text form: "2 h", "90 s", "1 h 30 min", "500 ms".
  [[nodiscard]] Duration duration(std::string_view key, std::optional<Duration> fallback = {}) const;
  /// Reads "-40 °C" or a bare number in °C.
  [[nodiscard]] Celsius celsius(std::string_view key, std::optional<Celsius> fallback = {}) const;
  /// Reads "2 K", "2 °C" or a bare number in kelvins.
  [[nodiscard]] Kelvins kelvins(std::string_view key, Kelvins fallback) const;
  /// Reads "5 °C/min" or a bare number in °C/min.
  [[nodiscard]] CelsiusPerMinute rate(std::string_view key, std::optional<CelsiusPerMinute> fallback = {}) const;
  /// Lowest rate by which a temperature difference is divided: 100 K then take less than ten weeks.
  static constexpr CelsiusPerMinute kLowestRate{0.001};
  /// Reads a rate as rate() does. A rate below kLowestRate is an error.
  [[nodiscard]] CelsiusPerMinute positive_rate(std::string_view key,
                                               std::optional<CelsiusPerMinute> fallback = {}) const;

  /// Reads a list or a table. The result is empty if the key is absent.
  [[nodiscard]] std::vector<double> numbers(std::string_view key) const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  [[nodiscard]] std::vector<std::vector<double>> number_rows(std::string_view key) const;
  [[nodiscard]] std::vector<CelsiusPerMinute> rates(std::string_view key) const;
  [[nodiscard]] std::vector<Duration> durations(std::string_view key) const;
  [[nodiscard]] TomlTable table(std::string_view key) const;
  [[nodiscard]] std::vector<TomlTable> tables(std::string_view key) const;
  /// Returns every key of this table in the order of the file, and marks all of them as read.
  [[nodiscard]] std::vector<std::string> keys() const;
  /// Marks a key as read, because another parser reads it.
  void ignore(std::string_view key) const;

  /// Returns "file:line:column" of a key, or of this table if the key is absent or empty.
  [[nodiscard]] std::string location(std::string_view key = {}) const;
  /// Notes an error that the parser found at a key. The same error is noted only once. If this table is absent, only
  /// its absence is noted.
  void note_error(std::string_view key, std::string what) const;

  /// Fails with bad_file if any table of the file has an error. `where` is the location of the first error. `what`
  /// lists up to 100 errors, one per line. Each line after the first begins with "file:line:column: ". Errors in the
  /// text of the file come first, in its order; missing keys follow. A missing key is not reported if a misspelt form
  /// of it was found.
  [[nodiscard]] Result<void> verdict() const;

 private:
  struct Document;
  struct Node;
  TomlTable(std::shared_ptr<Document> document, std::shared_ptr<Node> node);
  /// Marks the key as read and returns the node.
  [[nodiscard]] const Node& mark_read(std::string_view key) const;
  [[nodiscard]] std::string table_path(std::string_view key) const;
  std::shared_ptr<Document> document_;
  std::shared_ptr<Node> node_;
};

/// Keywords that a file may contain, each with its value.
template <class T, std::size_t N>
using Vocabulary = std::array<std::pair<const char*, T>, N>;

/// Makes a vocabulary with one keyword per enumerator, in the order from `First` to `Last`.
template <auto First, auto Last, class... Words>
[[nodiscard]] constexpr auto make_vocabulary(Words... words) {
  using T = decltype(First);
  auto value = static_cast<int>(First);
  static_assert(sizeof...(Words) == static_cast<int>(Last) - static_cast<int>(First) + 1);
  return Vocabulary<T, sizeof...(Words)>{{std::pair<const char*, T>(words, static_cast<T>(value++))...}};
}

/// Returns the keyword for `value`, or "" if there is none.
template <class T, std::size_t N>
[[nodiscard]] constexpr const char* keyword_for(const Vocabulary<T, N>& words, T value) {
  for (const auto& [word, meaning] : words)
    if (meaning == value) return word;
  return "";
}

/// Reads a keyword at `key` and returns its value. A text that is not a keyword is an error. Without `fallback` the key
/// is required.
template <class T, std::size_t N>
[[nodiscard]] T one_of(const Vocabulary<T, N>& words, const TomlTable& table, const char* key,
                       const char* fallback = "") {
  std::vector<std::string> allowed;
  for (const auto& [word, value] : words) allowed.emplace_back(word);
  const auto chosen = table.choice(key, allowed, fallback);
  const auto found = std::find_if(words.begin(), words.end(), [&](const auto& entry) { return chosen == entry.first; });
  return found == words.end() ? words.front().second : found->second;
}

/// Reads a keyword as one_of() does. Returns nothing if the key is absent or its text is "default".
template <class T, std::size_t N>
[[nodiscard]] std::optional<T> one_of_or_default(const Vocabulary<T, N>& words, const TomlTable& table,
                                                 const char* key) {
  if (!table.has(key) || table.text(key) == "default") return std::nullopt;
  return one_of(words, table, key);
}

/// Converts `value`, which was read at `key`, to a T. A value outside [low, high] is an error, and the nearest bound is
/// returned.
template <class T>
[[nodiscard]] T bounded(const TomlTable& table, const char* key, std::int64_t value, std::int64_t low,
                        std::int64_t high) {
  if (value < low || value > high)
    table.note_error(key, fmt::format("\"{}\" is {}, expected {} to {}", key, value, low, high));
  return static_cast<T>(std::clamp(value, low, high));
}

/// Reads a whole number in [low, high] at `key`. Without `fallback` the key is required.
template <class T>
[[nodiscard]] T whole(const TomlTable& table, const char* key, std::int64_t low, std::int64_t high,
                      std::optional<std::int64_t> fallback = {}) {
  return bounded<T>(table, key, table.integer(key, fallback), low, high);
}

/// Reads an unsigned 32-bit number at `key`.
[[nodiscard]] inline std::uint32_t read_uint32(const TomlTable& table, const char* key, std::int64_t fallback) {
  return whole<std::uint32_t>(table, key, 0, 0xFFFFFFFF, fallback);
}

/// Byte orders. The value is true if the most significant byte comes first.
inline constexpr Vocabulary<bool, 2> kEndians{{{"little", false}, {"big", true}}};

/// A file that another file names: its path and content.
struct NamedText {
  std::string path;
  std::string text;
};

/// Reads the file named at `key`: a path relative to the folder of `file`, or the name of a shipped file of `kind`. If
/// `known` has a value, such as the copy kept in a record, it is used as the content. Fails with bad_file at the
/// location of the key.
[[nodiscard]] Result<NamedText> read_named(const TomlTable& table, const char* key, const std::string& file,
                                           const ShippedKind& kind, const std::optional<std::string>& known);

}  // namespace gyrotherm
