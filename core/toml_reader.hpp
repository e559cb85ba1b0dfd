/// Reads TOML for people: every mistake of a file is reported at once, each with file:line:column.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/quantity.hpp"
#include "core/quantity_text.hpp"
#include "core/result.hpp"

namespace gyrotherm {

/// One table of a TOML file. A getter that finds a missing key, a wrong type or a wrong unit notes the mistake and
/// returns a neutral value, so that a parser reads straight on and asks `verdict()` once at its end. Keys never asked
/// for are mistakes too ("unknown key, did you mean …"). Copies share one list of mistakes.
class TomlTable {
 public:
  /// Parses a whole file's text. `file` is what places are reported under. Fails with bad_file on a syntax error, and
  /// where the text passes a bound (toml_text.hpp).
  [[nodiscard]] static Result<TomlTable> parse(std::string_view text, std::string file);

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] bool is_table(std::string_view key) const;
  [[nodiscard]] bool is_list(std::string_view key) const;

  [[nodiscard]] double number(std::string_view key) const;
  [[nodiscard]] double number(std::string_view key, double fallback) const;
  [[nodiscard]] std::int64_t integer(std::string_view key) const;
  [[nodiscard]] std::int64_t integer(std::string_view key, std::int64_t fallback) const;
  [[nodiscard]] bool boolean(std::string_view key, bool fallback) const;
  [[nodiscard]] std::string text(std::string_view key) const;
  [[nodiscard]] std::string text(std::string_view key, std::string fallback) const;
  /// A text that must be one of `allowed`; the nearest one is suggested.
  [[nodiscard]] std::string choice(std::string_view key, const std::vector<std::string>& allowed,
                                   std::string fallback = "") const;

  /// A text that must be exactly this one: a file's schema.
  void expect(std::string_view key, std::string_view value) const;

  /// Durations are text: "2 h", "90 s", "1 h 30 min", "500 ms".
  [[nodiscard]] Duration duration(std::string_view key) const;
  [[nodiscard]] Duration duration(std::string_view key, Duration fallback) const;
  /// "-40 °C" or a bare number in °C.
  [[nodiscard]] Celsius celsius(std::string_view key) const;
  [[nodiscard]] Celsius celsius(std::string_view key, Celsius fallback) const;
  /// "2 K", "2 °C" or a bare number in kelvins.
  [[nodiscard]] Kelvins kelvins(std::string_view key, Kelvins fallback) const;
  /// "5 °C/min" or a bare number in °C/min.
  [[nodiscard]] CelsiusPerMinute rate(std::string_view key) const;
  [[nodiscard]] CelsiusPerMinute rate(std::string_view key, CelsiusPerMinute fallback) const;

  [[nodiscard]] std::vector<double> numbers(std::string_view key) const;  ///< empty if absent
  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const;
  [[nodiscard]] std::vector<std::vector<double>> number_rows(std::string_view key) const;
  [[nodiscard]] std::vector<CelsiusPerMinute> rates(std::string_view key) const;
  [[nodiscard]] std::vector<Duration> durations(std::string_view key) const;

  [[nodiscard]] TomlTable table(std::string_view key) const;                ///< empty if absent
  [[nodiscard]] std::vector<TomlTable> tables(std::string_view key) const;  ///< [[key]], empty if absent
  [[nodiscard]] std::vector<std::string> keys() const;  ///< every key of this table, in order of the file
  void ignore(std::string_view key) const;              ///< someone else reads it

  /// "file:line:column" of a key, or of this table if the key is absent (or empty).
  [[nodiscard]] std::string place(std::string_view key = {}) const;
  /// Notes a mistake of the parser's own finding at a key; the same one again is not noted twice.
  void mistake(std::string_view key, std::string what) const;

  /// Fails with bad_file if any table of the file has a mistake: the first in `where`, all of them in `what`, one a
  /// line (each further line is a whole "file:line:column: what, what was expected"); of more than 100 only so many.
  [[nodiscard]] Result<void> verdict() const;

 private:
  struct Document;
  struct Node;
  TomlTable(std::shared_ptr<Document> document, std::shared_ptr<Node> node);
  /// The node, with the key marked as asked for.
  [[nodiscard]] const Node& ask(std::string_view key) const;
  std::shared_ptr<Document> document_;
  std::shared_ptr<Node> node_;
};

}  // namespace gyrotherm
