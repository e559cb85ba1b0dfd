// SPDX-License-Identifier: Apache-2.0
/// Reads TOML for people: every mistake of a file is reported at once, each with file:line:column. TomlTable reads
/// values; the functions below it read words that stand for values, bounded whole numbers, and files that are named.
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

/// One table of a TOML file. A getter that finds a missing key, a wrong type or a wrong unit notes the mistake and
/// returns a neutral value, so that a parser reads straight on and asks `verdict()` once at its end. Keys never asked
/// for are mistakes too ("unknown key, did you mean …"). Copies share one list of mistakes.
class TomlTable {
 public:
  /// Parses a whole file's text. Places are reported under `file`. Fails with bad_file on a syntax error, and where the
  /// text passes a bound (toml_text.hpp).
  [[nodiscard]] static Result<TomlTable> parse(std::string_view text, std::string file);

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_table(std::string_view key) const;
  [[nodiscard]] bool is_list(std::string_view key) const;

  /// Without a `fallback` the key is required.
  [[nodiscard]] double number(std::string_view key, std::optional<double> fallback = {}) const;
  [[nodiscard]] std::int64_t integer(std::string_view key, std::optional<std::int64_t> fallback = {}) const;
  [[nodiscard]] bool boolean(std::string_view key, std::optional<bool> fallback = {}) const;
  [[nodiscard]] std::string text(std::string_view key, const std::optional<std::string>& fallback = {}) const;
  /// Reads a text that must be one of `allowed`; of another one the mistake suggests the nearest.
  [[nodiscard]] std::string choice(std::string_view key, const std::vector<std::string>& allowed,
                                   std::string fallback = "") const;

  /// Notes a mistake unless the text is exactly this one, as of a file's schema. Where it is that of another kind of
  /// file ("gyrotherm-rig/1" for "gyrotherm-profile/1"), this is the only mistake that is told.
  void expect(std::string_view key, std::string_view value) const;

  /// Reads a duration, which is text: "2 h", "90 s", "1 h 30 min", "500 ms".
  [[nodiscard]] Duration duration(std::string_view key, std::optional<Duration> fallback = {}) const;
  /// Reads "-40 °C" or a bare number in °C.
  [[nodiscard]] Celsius celsius(std::string_view key, std::optional<Celsius> fallback = {}) const;
  /// Reads "2 K", "2 °C" or a bare number in kelvins.
  [[nodiscard]] Kelvins kelvins(std::string_view key, Kelvins fallback) const;
  /// Reads "5 °C/min" or a bare number in °C/min.
  [[nodiscard]] CelsiusPerMinute rate(std::string_view key, std::optional<CelsiusPerMinute> fallback = {}) const;
  /// The same; what is not above zero is a mistake.
  [[nodiscard]] CelsiusPerMinute positive_rate(std::string_view key,
                                               std::optional<CelsiusPerMinute> fallback = {}) const;

  /// Lists and tables are empty where the key is absent.
  [[nodiscard]] std::vector<double> numbers(std::string_view key) const;
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  [[nodiscard]] std::vector<std::vector<double>> number_rows(std::string_view key) const;
  [[nodiscard]] std::vector<CelsiusPerMinute> rates(std::string_view key) const;
  [[nodiscard]] std::vector<Duration> durations(std::string_view key) const;
  [[nodiscard]] TomlTable table(std::string_view key) const;
  [[nodiscard]] std::vector<TomlTable> tables(std::string_view key) const;  ///< [[key]]
  /// Every key of this table, in order of the file; all of them count as asked for.
  [[nodiscard]] std::vector<std::string> keys() const;
  /// Lets a key be there that someone else reads.
  void ignore(std::string_view key) const;

  /// "file:line:column" of a key, or of this table if the key is absent (or empty).
  [[nodiscard]] std::string place(std::string_view key = {}) const;
  /// Notes a mistake of the parser's own finding at a key; the same one again is not noted twice. Of a table that is
  /// absent the only mistake is that it is.
  void mistake(std::string_view key, std::string what) const;

  /// Fails with bad_file if any table of the file has a mistake: the first in `where`, all of them in `what`, one a
  /// line (each further line is a whole "file:line:column: what, what was expected"); of more than 100 only so many.
  /// What stands in the file comes first, in its order, then what is missing; a key that is missing because it was
  /// misspelt is not told of.
  [[nodiscard]] Result<void> verdict() const;

 private:
  struct Document;
  struct Node;
  TomlTable(std::shared_ptr<Document> document, std::shared_ptr<Node> node);
  /// Marks the key as asked for and returns the node.
  [[nodiscard]] const Node& ask(std::string_view key) const;
  [[nodiscard]] std::string path_of_table(std::string_view key) const;
  std::shared_ptr<Document> document_;
  std::shared_ptr<Node> node_;
};

/// Words of a file, and the value that each stands for.
template <class T, std::size_t N>
using Vocabulary = std::array<std::pair<const char*, T>, N>;

/// One word for each enumerator from `First` to `Last`, in their order.
template <auto First, auto Last, class... Words>
[[nodiscard]] constexpr auto words_in_order(Words... words) {
  using T = decltype(First);
  auto value = static_cast<int>(First);
  static_assert(sizeof...(Words) == static_cast<int>(Last) - static_cast<int>(First) + 1);
  return Vocabulary<T, sizeof...(Words)>{{std::pair<const char*, T>(words, static_cast<T>(value++))...}};
}

/// The word that stands for `value`; "" if none does.
template <class T, std::size_t N>
[[nodiscard]] constexpr const char* word_of(const Vocabulary<T, N>& words, T value) {
  for (const auto& [word, meaning] : words)
    if (meaning == value) return word;
  return "";
}

/// Reads a word at `key` and returns the value that it stands for; any other word is a mistake. Without a `fallback`
/// the key is required.
template <class T, std::size_t N>
[[nodiscard]] T one_of(const Vocabulary<T, N>& words, const TomlTable& table, const char* key,
                       const char* fallback = "") {
  std::vector<std::string> allowed;
  for (const auto& [word, value] : words) allowed.emplace_back(word);
  const auto chosen = table.choice(key, allowed, fallback);
  const auto found = std::find_if(words.begin(), words.end(), [&](const auto& entry) { return chosen == entry.first; });
  return found == words.end() ? words.front().second : found->second;
}

/// The same where the key may be absent, or "default": then nothing.
template <class T, std::size_t N>
[[nodiscard]] std::optional<T> one_of_or_default(const Vocabulary<T, N>& words, const TomlTable& table,
                                                 const char* key) {
  if (!table.has(key) || table.text(key) == "default") return std::nullopt;
  return one_of(words, table, key);
}

/// Returns `value`, which was read at `key`, as a T. Outside [low, high] it is a mistake, and the nearest bound is
/// returned.
template <class T>
[[nodiscard]] T bounded(const TomlTable& table, const char* key, std::int64_t value, std::int64_t low,
                        std::int64_t high) {
  if (value < low || value > high)
    table.mistake(key, fmt::format("\"{}\" is {}, expected {} to {}", key, value, low, high));
  return static_cast<T>(std::clamp(value, low, high));
}

/// Reads a whole number at `key` that lies in [low, high]. Without a `fallback` the key is required.
template <class T>
[[nodiscard]] T whole(const TomlTable& table, const char* key, std::int64_t low, std::int64_t high,
                      std::optional<std::int64_t> fallback = {}) {
  return bounded<T>(table, key, table.integer(key, fallback), low, high);
}

/// Reads a whole number of 32 bits at `key`.
[[nodiscard]] inline std::uint32_t word32(const TomlTable& table, const char* key, std::int64_t fallback) {
  return whole<std::uint32_t>(table, key, 0, 0xFFFFFFFF, fallback);
}

/// The orders of bytes, and whether the most significant one comes first.
inline constexpr Vocabulary<bool, 2> kEndians{{{"little", false}, {"big", true}}};

/// A file that another one names, and what stands in it.
struct NamedText {
  std::string path;
  std::string text;
};

/// Reads the file that `key` names: a path relative to the folder of `file`, or the name of a shipped file of `kind`.
/// `known`, as a record keeps it, takes the place of its text. Fails with bad_file, at the place of the key.
[[nodiscard]] Result<NamedText> read_named(const TomlTable& table, const char* key, const std::string& file,
                                           const ShippedKind& kind, const std::optional<std::string>& known);

}  // namespace gyrotherm
