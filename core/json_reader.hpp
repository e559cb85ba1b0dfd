// SPDX-License-Identifier: Apache-2.0
/// Reads a JSON document key by key: the first mistake is kept with its path, and a neutral value is returned in its
/// place, so that a parser reads straight on and asks verdict() once.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace gyrotherm {

/// A place in a document; copies share the document and its one mistake.
class JsonPlace {
 public:
  /// Whether a number may be null, which is NaN then.
  enum class Nulls { are_nan, are_mistakes };
  /// Fails with bad_file on a syntax error; the place is file:line:column.
  [[nodiscard]] static Result<JsonPlace> parse(std::string_view text, std::string file, Nulls nulls = Nulls::are_nan);

  [[nodiscard]] bool has(std::string_view key) const;  ///< an object with that key

  [[nodiscard]] JsonPlace operator[](std::string_view key) const;                ///< of an object
  [[nodiscard]] std::vector<JsonPlace> elements() const;                         ///< of an array
  [[nodiscard]] std::vector<std::pair<std::string, JsonPlace>> members() const;  ///< of an object, in order of the file

  [[nodiscard]] bool is_null() const;  ///< there, and null
  [[nodiscard]] double number() const;
  [[nodiscard]] int integer() const;
  [[nodiscard]] std::int64_t long_integer() const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::uint64_t whole() const;  ///< a whole number not below 0
  [[nodiscard]] std::vector<double> numbers() const;
  [[nodiscard]] std::vector<std::string> texts() const;

  /// Notes a mistake of the parser's own finding here.
  void mistake(const std::string& what) const;
  [[nodiscard]] Result<void> verdict() const;

 private:
  struct Document;
  JsonPlace(std::shared_ptr<Document> document, const void* node, std::string path);
  std::shared_ptr<Document> document_;
  const void* node_;  ///< null once a mistake was made on the way here
  std::string path_;
};

}  // namespace gyrotherm
