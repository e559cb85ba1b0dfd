// SPDX-License-Identifier: Apache-2.0
/// The bytes of a file of any size, a piece of them in memory at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/file.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Goes from the first byte of a file to its last.
class Bytes {
 public:
  /// Fails as open_regular_file() does.
  [[nodiscard]] static Result<Bytes> open(const std::string& path);
  /// Goes through a text that outlives this; `name` stands for its file in faults.
  Bytes(std::string_view all, std::string name) : name_(std::move(name)), ahead_(all) {}

  /// What comes next: at least `count` bytes, fewer only where the file ends. The view is good until the next call.
  /// Fails with bad_file if the file cannot be read.
  [[nodiscard]] Result<std::string_view> ahead(std::size_t count);
  /// Goes on by so many bytes, which ahead() has shown.
  void pass(std::size_t count);
  /// Goes back to where so many bytes were passed. Fails with bad_file if the file cannot be read.
  [[nodiscard]] Result<void> go_back(std::uint64_t to);

  /// Bytes that were passed.
  [[nodiscard]] std::uint64_t passed() const { return passed_; }
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  explicit Bytes(RegularFile file, std::string name) : name_(std::move(name)), file_(std::move(file)) {}
  [[nodiscard]] Result<void> read_more(std::size_t count);

  std::string name_;
  RegularFile file_{};
  std::string buffer_{};
  std::string_view ahead_{};  ///< of the buffer, or of the text in memory
  std::uint64_t passed_{};
  bool at_end_ = false;  ///< all of the file is in the buffer or passed
};

}  // namespace gyrotherm::exchange
