// SPDX-License-Identifier: Apache-2.0
/// Unpacks a gzip file (RFC 1952) as it is read, by zlib. Members that follow each other make one content.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Returns true if a file that begins so is a gzip file.
[[nodiscard]] bool is_gzip(std::string_view beginning);

/// Unpacks one file from its first byte to its last. Holds a piece of it in memory, however large the content is.
class Gunzip {
 public:
  /// Begins at the file's first byte, where an open descriptor stands that outlives this. Faults have `name` for the
  /// file.
  Gunzip(int descriptor, std::string_view name);
  ~Gunzip();
  Gunzip(Gunzip&&) noexcept;
  Gunzip& operator=(Gunzip&&) noexcept;

  /// Writes up to `room` bytes of content to `to` and returns how many; 0 at the end. Fails with bad_file, with the
  /// position in the packed file, if it cannot be read, is damaged or ends too early.
  [[nodiscard]] Result<std::size_t> read(char* to, std::size_t room);

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace gyrotherm::exchange
