/// The chain over a record's rows: each carries the beginning of a hash of itself and of the whole hash before it, so
/// that a row that was changed, taken out, put in or moved no longer fits. It begins with what the run knew at its
/// start. It makes edits evident, not impossible: who may write the file may also chain it anew.
#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/sha256.hpp"

namespace gyrotherm {

class RowChain {
 public:
  RowChain() = default;
  explicit RowChain(const Digest& head) : head_(head) {}

  /// A row: begin(), each value in the order of its columns, end().
  void begin(std::string_view table);
  template <std::integral T>
  void add(T value) {
    add_integer(static_cast<std::int64_t>(value));
  }
  /// NaN is what the file has as NULL; a whole number is the same as an integer, as to the file.
  void add(double value);
  void add(std::string_view value);
  void add_null();
  /// What the row carries: the first 8 bytes of the hash that the next row continues.
  std::int64_t end();

  [[nodiscard]] const Digest& head() const { return head_; }

 private:
  void add_integer(std::int64_t value);
  void add_bits(char type, std::uint64_t bits);

  Digest head_{};
  std::string row_;
};

}  // namespace gyrotherm
