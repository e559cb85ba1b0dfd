// SPDX-License-Identifier: Apache-2.0
/// Reads a JSON document key by key. A getter that finds an error returns a neutral value, and the document keeps the
/// first error with its path. A parser therefore reads all keys and then calls verdict().
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

/// A position in a document. Copies share the document and its first error.
class JsonNode {
 public:
  /// Selects whether a number may be null, which is read as NaN.
  enum class Nulls { read_as_nan, are_errors };
  /// Parses a document. Fails with bad_file on a syntax error; `where` is file:line:column.
  [[nodiscard]] static Result<JsonNode> parse(std::string_view text, std::string file,
                                              Nulls nulls = Nulls::read_as_nan);

  /// Returns whether this is an object with that key.
  [[nodiscard]] bool has(std::string_view key) const;

  /// Returns the value at a key of an object. A missing key is an error.
  [[nodiscard]] JsonNode operator[](std::string_view key) const;
  /// Returns the elements of an array.
  [[nodiscard]] std::vector<JsonNode> elements() const;
  /// Returns the keys and values of an object, in the order of the file.
  [[nodiscard]] std::vector<std::pair<std::string, JsonNode>> members() const;

  /// Returns whether the value is present and null.
  [[nodiscard]] bool is_null() const;
  [[nodiscard]] double number() const;
  [[nodiscard]] int integer() const;
  [[nodiscard]] std::int64_t long_integer() const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::uint64_t whole() const;  ///< at least 0
  [[nodiscard]] std::vector<double> numbers() const;
  [[nodiscard]] std::vector<std::string> texts() const;

  /// Notes an error that the parser found at this position.
  void note_error(const std::string& what) const;
  /// Fails with bad_file if an error was noted in the document; the message describes the first one.
  [[nodiscard]] Result<void> verdict() const;

 private:
  struct Document;
  JsonNode(std::shared_ptr<Document> document, const void* node, std::string path);
  std::shared_ptr<Document> document_;
  /// Null if this position does not exist in the document.
  const void* node_;
  std::string path_;
};

}  // namespace gyrotherm
