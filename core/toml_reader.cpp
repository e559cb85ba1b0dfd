// SPDX-License-Identifier: Apache-2.0
#include "core/toml_reader.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "core/file.hpp"
#include "core/number_hint.hpp"
#include "core/text.hpp"
#include "core/toml_text.hpp"

namespace gyrotherm {
namespace {

constexpr std::size_t kMaxErrors = 100;  ///< listed per file

std::string missing_key(std::string_view key) { return fmt::format("missing key \"{}\"", key); }

}  // namespace

struct TomlTable::Document {
  /// Sort order of the errors. Errors at existing keys come first, because they often cause the errors about missing
  /// keys.
  enum class Rank { key_error, missing_error };

  struct TomlError {
    Rank rank;
    toml::source_position at;
    std::string what;
    bool operator==(const TomlError&) const = default;
  };

  /// The first kMaxErrors errors, and whether there were more.
  class ErrorList {
   public:
    void note(TomlError error) {
      if (std::find(noted_.begin(), noted_.end(), error) != noted_.end()) return;
      more_ = more_ || is_full();
      if (!is_full()) noted_.push_back(std::move(error));
    }
    [[nodiscard]] bool is_full() const { return noted_.size() == kMaxErrors; }
    [[nodiscard]] bool has_more() const { return more_; }
    [[nodiscard]] bool empty() const { return noted_.empty(); }
    /// Returns whether a key is missing, or its value was refused. Further errors about it are consequences.
    [[nodiscard]] bool has_refused(toml::source_position at, std::string_view key) const {
      const auto missing = missing_key(key), refused = fmt::format("\"{}\" is ", key);
      return std::ranges::any_of(noted_, [&](const TomlError& one) {
        return one.at == at && (one.what.starts_with(missing) || one.what.starts_with(refused));
      });
    }
    /// Removes the error about a missing key, because a misspelt form of the key was found.
    void drop_missing(toml::source_position table, std::string_view key) {
      const auto start = missing_key(key);
      std::erase_if(noted_, [&](const TomlError& one) { return one.at == table && one.what.starts_with(start); });
    }
    [[nodiscard]] std::vector<TomlError> sorted_errors() const {
      auto sorted = noted_;
      std::stable_sort(sorted.begin(), sorted.end(), [](const TomlError& a, const TomlError& b) {
        return a.rank != b.rank ? a.rank < b.rank : a.at < b.at;
      });
      return sorted;
    }

   private:
    std::vector<TomlError> noted_;
    bool more_ = false;
  };

  std::string file;
  toml::table root;
  ErrorList errors;
  /// If set, it is the only error reported.
  std::optional<TomlError> other_kind{};
  std::vector<std::shared_ptr<Node>> nodes;                                     ///< one per table that was read
  std::unordered_map<const toml::table*, std::shared_ptr<Node>> known_nodes{};  ///< nodes by table

  [[nodiscard]] std::string location(toml::source_position at) const {
    return fmt::format("{}:{}:{}", file, std::max<unsigned>(at.line, 1), std::max<unsigned>(at.column, 1));
  }
  /// Returns the noted errors and one for each key that was never read.
  [[nodiscard]] ErrorList collect_errors() const;
  /// Returns where a key belongs that is unknown in `node`, with "; " in front: another table has it and lacks it here.
  /// Otherwise returns an empty text.
  [[nodiscard]] std::string hint_at_table(const Node& node, std::string_view key) const;
};

struct TomlTable::Node {
  const toml::table* table = nullptr;  ///< null for an absent table
  toml::source_position at{};
  /// Dotted path, such as "chamber". An absent table in an absent table has the path of the outer one.
  std::string path{};
  /// The absence of this table, or its wrong type, has been noted; further errors in it are dropped.
  bool is_reported{};
  std::set<std::string, std::less<>> read_keys;

  /// Returns the position of the key, or of the table if the key is absent.
  [[nodiscard]] toml::source_position at_key(std::string_view key) const {
    const auto* node = table && !key.empty() ? table->get(key) : nullptr;
    return node ? node->source().begin : at;
  }
};

std::string TomlTable::Document::hint_at_table(const Node& node, std::string_view key) const {
  const auto owner = std::ranges::find_if(nodes, [&](const std::shared_ptr<Node>& other) {
    return other->path != node.path && other->read_keys.contains(key) && !other->table->contains(key);
  });
  if (owner == nodes.end()) return {};
  return (*owner)->path.empty() ? "; it belongs before the first table"
                                : fmt::format("; it belongs in [{}]", (*owner)->path);
}

TomlTable::Document::ErrorList TomlTable::Document::collect_errors() const {
  auto all = errors;
  for (const auto& node : nodes)
    for (const auto& [key, value] : *node->table) {
      if (node->read_keys.contains(key.str())) continue;
      // A key that is present is not meant, except for another table of an array.
      std::vector<std::string> possible_keys;
      for (const auto& known : node->read_keys)
        if (const auto* there = node->table->get(known); !there || there->is_array_of_tables())
          possible_keys.push_back(known);
      const auto near = all.is_full() ? std::string() : find_nearest(key.str(), possible_keys);
      const auto meant = near.empty() ? hint_at_table(*node, key.str()) : fmt::format(", did you mean \"{}\"?", near);
      if (!near.empty()) all.drop_missing(node->at, near);
      all.note({Rank::key_error, key.source().begin, fmt::format("unknown key \"{}\"{}", key.str(), meant)});
      if (all.has_more()) return all;
    }
  return all;
}

TomlTable::TomlTable(std::shared_ptr<Document> document, std::shared_ptr<Node> node)
    : document_(std::move(document)), node_(std::move(node)) {
  if (!node_->table) return;
  const auto [entry, is_new] = document_->known_nodes.emplace(node_->table, node_);
  node_ = entry->second;
  if (is_new) document_->nodes.push_back(node_);
}

namespace {

/// Texts that begin with this stand for a value that a person is to fill in.
constexpr std::string_view kToFillIn = "FILL IN";

/// Returns the remedy for a value that begins with a letter but is not a keyword of TOML.
std::string_view hint_at_bare_value(std::string_view value) {
  for (const std::string_view word : {"yes", "no", "on", "off", "True", "False", "TRUE", "FALSE"})
    if (value.starts_with(word)) return "; expected true or false";
  return "; a text has quotation marks";
}

/// Returns the remedy for the usual syntax errors, with "; " in front: a decimal comma, a text without quotation marks,
/// and a table that is defined twice. Otherwise returns an empty text.
std::string_view hint_at_syntax(std::string_view text, toml::source_position at, std::string_view description) {
  if (description.find("cannot redefine existing table") != std::string_view::npos)
    return "; if there are several, each is written with two brackets, as [[thermometer]]";
  for (unsigned line = 1; line < at.line && !text.empty(); ++line)
    text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  text = text.substr(0, text.find('\n'));
  const std::size_t column = at.column > 0 ? at.column - 1 : 0;
  if (column > 0 && column + 1 < text.size() && text[column] == ',' &&
      !hint_at_number(text.substr(column - 1, 3)).empty())
    return "; a number has a decimal point";
  const auto equals = text.find('=');
  if (equals == std::string_view::npos || column < equals) return {};
  const auto value = trimmed(text.substr(equals + 1));
  const bool is_letter = !value.empty() && ((value[0] | 0x20) >= 'a' && (value[0] | 0x20) <= 'z');
  return is_letter ? hint_at_bare_value(value) : "";
}

struct ToFillIn {
  toml::source_position at;
  std::string what;
};

/// Collects the values of a table and of the tables in it that a person is to fill in.
void collect_to_fill_in(const toml::node& node, const std::string& key, std::vector<ToFillIn>& found) {
  if (const auto* table = node.as_table()) {
    for (const auto& [name, value] : *table) collect_to_fill_in(value, std::string(name.str()), found);
  } else if (const auto* list = node.as_array()) {
    for (const auto& element : *list) collect_to_fill_in(element, key, found);
  } else if (const auto* text = node.as_string(); text && text->get().starts_with(kToFillIn)) {
    const auto request = trimmed(std::string_view(text->get()).substr(kToFillIn.size()), ": ");
    found.push_back({node.source().begin,
                     fmt::format("\"{}\" is still to be filled in{}{}", key, request.empty() ? "" : ": ", request)});
  }
}

}  // namespace

Result<TomlTable> TomlTable::parse(std::string_view text, std::string file) {
  auto document = std::make_shared<Document>();
  document->file = std::move(file);
  if (const auto other = detect_other_format(text); !other.empty())
    return failure(FaultKind::bad_file, document->location({1, 1}), fmt::format("is {}, expected TOML", other));
  if (auto flaw = find_flaw(text))
    return failure(FaultKind::bad_file, document->location({flaw->line, flaw->column}), std::move(flaw->what));
  try {
    document->root = toml::parse(text, document->file);
  } catch (const toml::parse_error& error) {
    return failure(
        FaultKind::bad_file, document->location(error.source().begin),
        fmt::format("{}{}", error.description(), hint_at_syntax(text, error.source().begin, error.description())));
  }
  auto node = std::make_shared<Node>();
  node->table = &document->root;
  node->at = {1, 1};
  std::vector<ToFillIn> to_fill_in;
  collect_to_fill_in(document->root, "", to_fill_in);
  for (auto& one : to_fill_in) document->errors.note({Document::Rank::key_error, one.at, std::move(one.what)});
  const TomlTable table(std::move(document), std::move(node));
  if (to_fill_in.empty()) return table;
  for (const auto& key : table.keys()) table.ignore(key);
  return failure(table.verdict().error());
}

namespace {

const toml::node* find(const toml::table* table, std::string_view key) { return table ? table->get(key) : nullptr; }

bool is_empty_text(const toml::node* node) { return node != nullptr && node->value<std::string>() == ""; }

std::optional<double> as_number(const toml::node& node) {
  const auto value = node.value<double>();
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<double> as_unit(const toml::node& node, std::span<const std::string_view> units) {
  if (node.is_number()) return as_number(node);
  if (const auto* text = node.as_string()) return parse_quantity(text->get(), units);
  return std::nullopt;
}

std::optional<Duration> as_duration(const toml::node& node) {
  const auto* text = node.as_string();
  if (!text) return std::nullopt;
  const auto d = parse_duration(text->get());
  return d ? std::optional(*d) : std::nullopt;
}

constexpr std::array<std::string_view, 2> kCelsius{"°C", "C"};
constexpr std::array<std::string_view, 2> kKelvins{"K", "°C"};
constexpr std::array<std::string_view, 2> kRates{"°C/min", "K/min"};

constexpr const char* kExpectNumber = "expected a number";
constexpr const char* kExpectInteger = "expected a whole number";
constexpr const char* kExpectBoolean = "expected true or false";
constexpr const char* kExpectText = "expected text";
constexpr const char* kExpectDuration = "expected a duration like \"2 h\" or \"90 s\"";
constexpr const char* kExpectCelsius = "expected a temperature like 20 or \"20 °C\"";
constexpr const char* kExpectKelvins = "expected a temperature difference like 2 or \"2 K\"";
constexpr const char* kExpectRate = "expected a rate like 5 or \"5 °C/min\"";
constexpr const char* kExpectArray = "expected an array";

/// Describes a value for an error message: tables and lists by their type, others by their text if it is short.
std::string describe_value(const toml::node& node) {
  constexpr std::size_t kMaxQuotedLength = 40;
  if (node.is_table()) return "a table";
  if (node.is_array()) return "a list";
  std::ostringstream text;
  if (const auto* string = node.as_string())
    text << '"' << string->get() << '"';
  else if (const auto* number = node.as_floating_point())
    text << fmt::format("{}{}", number->get(), std::trunc(number->get()) == number->get() ? ".0" : "");
  else
    text << toml::toml_formatter{node};
  return text.str().size() > kMaxQuotedLength ? "something else" : text.str();
}

/// Returns how to write a value that was refused, with "; " in front; an empty text if that is unknown.
std::string hint_at(const toml::node& node) {
  const auto* string = node.as_string();
  const auto hint = string ? hint_at_number(string->get()) : std::string();
  return hint.empty() ? hint : "; " + hint;
}

/// Reads one key with a converter. Notes an error if the key is missing and there is no fallback, or if the value does
/// not convert.
template <class T, class Convert>
T read(const TomlTable& self, const toml::table* table, std::string_view key, const std::optional<T>& fallback,
       const char* expected, Convert convert) {
  const auto* node = find(table, key);
  if (!node) {
    if (!fallback) self.note_error("", missing_key(key) + ", " + expected);
    return fallback.value_or(T{});
  }
  if (const auto value = convert(*node)) return *value;
  self.note_error(key, fmt::format("\"{}\" is {}, {}{}", key, describe_value(*node), expected, hint_at(*node)));
  return fallback.value_or(T{});
}

template <class T, class Convert>
std::vector<T> read_array(const TomlTable& self, const toml::table* table, std::string_view key, const char* expected,
                          Convert convert) {
  std::vector<T> values;
  const auto* node = find(table, key);
  if (!node) return values;
  const auto* array = node->as_array();
  if (!array) self.note_error(key, fmt::format("\"{}\" is not an array, {}", key, kExpectArray));
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    if (const auto value = convert(*array->get(i)))
      values.push_back(*value);
    else
      self.note_error(key, fmt::format("element {} of \"{}\" is {}, {}{}", i + 1, key, describe_value(*array->get(i)),
                                       expected, hint_at(*array->get(i))));
  }
  return values;
}

std::optional<std::string> as_text(const toml::node& node) {
  const auto* text = node.as_string();
  return text ? std::optional(text->get()) : std::nullopt;
}
std::optional<std::int64_t> as_integer(const toml::node& node) {
  return node.is_integer() ? node.value<std::int64_t>() : std::nullopt;
}
std::optional<bool> as_boolean(const toml::node& node) { return node.is_boolean() ? node.value<bool>() : std::nullopt; }

template <class T>
auto as_quantity(std::span<const std::string_view> units) {
  return [units](const toml::node& node) -> std::optional<T> {
    const auto value = as_unit(node, units);
    return value ? std::optional(T{*value}) : std::nullopt;
  };
}

std::optional<std::vector<double>> as_row(const toml::node& node) {
  const auto* array = node.as_array();
  if (!array) return std::nullopt;
  std::vector<double> row;
  for (const auto& element : *array) {
    const auto value = as_number(element);
    if (!value) return std::nullopt;
    row.push_back(*value);
  }
  return row;
}

}  // namespace

const TomlTable::Node& TomlTable::mark_read(std::string_view key) const {
  node_->read_keys.emplace(key);
  return *node_;
}

bool TomlTable::has(std::string_view key) const { return find(mark_read(key).table, key) != nullptr; }

bool TomlTable::is_table(std::string_view key) const {
  const auto* node = find(mark_read(key).table, key);
  return node && node->is_table();
}

bool TomlTable::is_list(std::string_view key) const {
  const auto* node = find(mark_read(key).table, key);
  return node && node->is_array();
}

bool TomlTable::is_text(std::string_view key) const {
  const auto* node = find(mark_read(key).table, key);
  const auto* list = node ? node->as_array() : nullptr;
  return node && (node->is_string() || (list && !list->empty() && list->front().is_string()));
}

double TomlTable::number(std::string_view key, std::optional<double> fallback) const {
  return read(*this, mark_read(key).table, key, fallback, kExpectNumber, as_number);
}
std::int64_t TomlTable::integer(std::string_view key, std::optional<std::int64_t> fallback) const {
  return read(*this, mark_read(key).table, key, fallback, kExpectInteger, as_integer);
}
bool TomlTable::boolean(std::string_view key, std::optional<bool> fallback) const {
  return read(*this, mark_read(key).table, key, fallback, kExpectBoolean, as_boolean);
}
std::string TomlTable::text(std::string_view key, const std::optional<std::string>& fallback) const {
  return read(*this, mark_read(key).table, key, fallback, kExpectText, as_text);
}

namespace {

/// Lists keywords, in quotes if one of them is a mark such as a comma.
std::string list_choices(const std::vector<std::string>& allowed) {
  const auto is_mark = [](const std::string& word) {
    return std::ranges::none_of(word, [](unsigned char c) { return std::isalnum(c) != 0 || c >= 0x80; });
  };
  if (std::ranges::none_of(allowed, is_mark)) return fmt::format("{}", fmt::join(allowed, ", "));
  return fmt::format("\"{}\"", fmt::join(allowed, "\", \""));
}

}  // namespace

std::string TomlTable::choice(std::string_view key, const std::vector<std::string>& allowed,
                              std::string fallback) const {
  const auto value = text(key, fallback.empty() ? std::nullopt : std::optional(std::move(fallback)));
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return value;
  if (value.empty() && !is_empty_text(find(node_->table, key))) return value;  // missing or no text, noted by text()
  const auto near = find_nearest(value, allowed);
  note_error(key, fmt::format("\"{}\" is not one of {}{}", value, list_choices(allowed),
                              near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near)));
  return allowed.front();
}

void TomlTable::expect(std::string_view key, std::string_view value) const {
  const auto expected = fmt::format("expected \"{}\"", value);
  const auto found = read(*this, mark_read(key).table, key, std::optional<std::string>(), expected.c_str(), as_text);
  if (found == value) return;
  if (found.empty() && !is_empty_text(find(node_->table, key))) return;  // missing or no text, noted by text()
  const auto kind = [](std::string_view schema) { return schema.substr(0, schema.find('/')); };
  if (found.empty() || kind(found) == kind(value))
    return note_error(key, fmt::format("\"{}\" is not understood, expected \"{}\"", found, value));
  document_->other_kind = {Document::Rank::key_error, node_->at_key(key),
                           fmt::format("the schema of this file is {}, expected {}", found, value)};
}

Duration TomlTable::duration(std::string_view key, std::optional<Duration> fallback) const {
  return read(*this, mark_read(key).table, key, fallback, kExpectDuration, as_duration);
}
Celsius TomlTable::celsius(std::string_view key, std::optional<Celsius> fallback) const {
  return read(*this, mark_read(key).table, key, fallback, kExpectCelsius, as_quantity<Celsius>(kCelsius));
}
Kelvins TomlTable::kelvins(std::string_view key, Kelvins fallback) const {
  return read(*this, mark_read(key).table, key, std::optional(fallback), kExpectKelvins,
              as_quantity<Kelvins>(kKelvins));
}
CelsiusPerMinute TomlTable::rate(std::string_view key, std::optional<CelsiusPerMinute> fallback) const {
  return read(*this, mark_read(key).table, key, fallback, kExpectRate, as_quantity<CelsiusPerMinute>(kRates));
}
CelsiusPerMinute TomlTable::positive_rate(std::string_view key, std::optional<CelsiusPerMinute> fallback) const {
  const auto found = rate(key, fallback);
  if (!(found >= kLowestRate)) note_error(key, fmt::format("expected at least {} °C/min", kLowestRate.value));
  return found;
}

std::vector<double> TomlTable::numbers(std::string_view key) const {
  return read_array<double>(*this, mark_read(key).table, key, kExpectNumber, as_number);
}
std::vector<std::string> TomlTable::texts(std::string_view key) const {
  return read_array<std::string>(*this, mark_read(key).table, key, kExpectText, as_text);
}
std::vector<std::vector<double>> TomlTable::number_rows(std::string_view key) const {
  return read_array<std::vector<double>>(*this, mark_read(key).table, key, kExpectNumber, as_row);
}
std::vector<CelsiusPerMinute> TomlTable::rates(std::string_view key) const {
  return read_array<CelsiusPerMinute>(*this, mark_read(key).table, key, kExpectRate,
                                      as_quantity<CelsiusPerMinute>(kRates));
}
std::vector<Duration> TomlTable::durations(std::string_view key) const {
  return read_array<Duration>(*this, mark_read(key).table, key, kExpectDuration, as_duration);
}

std::string TomlTable::table_path(std::string_view key) const {
  if (!node_->table) return node_->path;
  return node_->path.empty() ? std::string(key) : fmt::format("{}.{}", node_->path, key);
}

TomlTable TomlTable::table(std::string_view key) const {
  auto child = std::make_shared<Node>();
  child->at = node_->at;
  child->path = table_path(key);
  child->is_reported = node_->is_reported;
  if (const auto* node = find(mark_read(key).table, key)) {
    child->table = node->as_table();
    child->at = node->source().begin;
    if (!child->table) note_error(key, fmt::format("\"{}\" is not a table, expected [{}]", key, key));
    child->is_reported = !child->table;
  }
  return {document_, std::move(child)};
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  std::vector<TomlTable> children;
  const auto* node = find(mark_read(key).table, key);
  const auto* array = node ? node->as_array() : nullptr;
  if (node && !array) note_error(key, fmt::format("\"{}\" is not an array of tables, expected [[{}]]", key, key));
  for (std::size_t i = 0; array && i < array->size(); ++i) {
    auto child = std::make_shared<Node>();
    child->table = array->get(i)->as_table();
    child->at = array->get(i)->source().begin;
    child->path = table_path(key);
    if (!child->table) note_error(key, fmt::format("element {} of \"{}\" is not a table", i + 1, key));
    child->is_reported = !child->table;
    children.push_back(TomlTable(document_, std::move(child)));
  }
  return children;
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::pair<toml::source_position, std::string>> found;
  if (node_->table)
    for (const auto& [key, value] : *node_->table) {
      node_->read_keys.emplace(key.str());
      found.emplace_back(key.source().begin, std::string(key.str()));
    }
  std::stable_sort(found.begin(), found.end(), [](auto& a, auto& b) { return a.first < b.first; });
  std::vector<std::string> names;
  for (auto& [at, key] : found) names.push_back(std::move(key));
  return names;
}

void TomlTable::ignore(std::string_view key) const { node_->read_keys.emplace(key); }

std::string TomlTable::location(std::string_view key) const { return document_->location(node_->at_key(key)); }

void TomlTable::note_error(std::string_view key, std::string what) const {
  using Rank = Document::Rank;
  if (node_->is_reported) return;
  if (!node_->table)
    return document_->errors.note({Rank::missing_error, node_->at, fmt::format("missing [{}]", node_->path)});
  if (!key.empty() && document_->errors.has_refused(node_->at_key(key), key)) return;
  const auto rank = find(node_->table, key) ? Rank::key_error : Rank::missing_error;
  document_->errors.note({rank, node_->at_key(key), std::move(what)});
}

Result<void> TomlTable::verdict() const {
  if (const auto& other = document_->other_kind)
    return failure(FaultKind::bad_file, document_->location(other->at), other->what);
  const auto all = document_->collect_errors();
  const auto errors = all.sorted_errors();
  if (errors.empty()) return {};
  std::string what = errors.front().what;
  for (std::size_t i = 1; i < errors.size(); ++i)
    what += fmt::format("\n{}: {}", document_->location(errors[i].at), errors[i].what);
  if (all.has_more()) what += fmt::format("\n{}: more errors than the {} reported here", document_->file, kMaxErrors);
  return failure(FaultKind::bad_file, document_->location(errors.front().at), std::move(what));
}

namespace {

/// Returns the name of the shipped file that a path without a file probably stands for, with "; " in front.
std::string suggest_shipped(const std::string& path, const ShippedKind& kind) {
  const auto stem = std::filesystem::path(path).stem().string();
  const auto names = shipped_names(kind);
  if (std::find(names.begin(), names.end(), stem) == names.end()) return {};
  return fmt::format("; the shipped {} is named \"{}\"", kind.what, stem);
}

}  // namespace

Result<NamedText> read_named(const TomlTable& table, const char* key, const std::string& file, const ShippedKind& kind,
                             const std::optional<std::string>& known) {
  const auto name = table.text(key);
  NamedText named{.path = (std::filesystem::path(file).parent_path() / name).lexically_normal().string(),
                  .text = known.value_or("")};
  if (known) return named;
  if (!name.empty() && !is_path(name)) {
    auto shipped = resolve_path(name, kind);
    if (!shipped) return failure(FaultKind::bad_file, table.location(key), gyrotherm::text(shipped.error()));
    named.path = std::move(*shipped);
  }
  auto text = read_text_file(named.path);
  if (!text)
    return failure(FaultKind::bad_file, table.location(key),
                   text.error().where + " " + text.error().what + suggest_shipped(name, kind));
  named.text = std::move(*text);
  return named;
}

}  // namespace gyrotherm
