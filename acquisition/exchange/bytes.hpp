// SPDX-License-Identifier: Apache-2.0
/// Reads the bytes of a file of any size, and holds only one piece in memory at a time. Unpacks a gzip file while
/// reading it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/file.hpp"
#include "core/result.hpp"

namespace gyrotherm::exchange {

/// Unpacks a gzip file (RFC 1952) sequentially with zlib. The contents of consecutive members are concatenated. Holds
/// only one piece of the content in memory.
class Gunzip {
 public:
  /// Takes an open descriptor at the start of the file. The descriptor must outlive this object. `name` is the file's
  /// name in faults.
  Gunzip(int descriptor, std::string_view name);
  ~Gunzip();
  Gunzip(Gunzip&&) noexcept;
  Gunzip& operator=(Gunzip&&) noexcept;

  /// Writes up to `capacity` bytes of content to `to` and returns their number; 0 at the end. Fails with bad_file and
  /// the position in the packed file if the file cannot be read, is damaged or ends too early.
  [[nodiscard]] Result<std::size_t> read(char* to, std::size_t capacity);

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

/// Reads a file sequentially.
class Bytes {
 public:
  /// Fails as open_regular_file() does, and with bad_file if the file cannot be read.
  [[nodiscard]] static Result<Bytes> open(const std::string& path);
  /// Reads a text in memory, which must outlive this object. `name` is the file's name in faults.
  Bytes(std::string_view all, std::string name) : name_(std::move(name)), unread_(all) {}

  /// Returns the bytes at the present position: at least `count`, or fewer at the end of the file. The view is valid
  /// until the next call. Fails with bad_file if the file cannot be read or unpacked.
  [[nodiscard]] Result<std::string_view> peek(std::size_t count);
  /// Advances by `count` bytes, which peek() must have returned.
  void skip(std::size_t count);
  /// Moves back to the earlier position `to`. For a gzip file, unpacks it again from its start. Fails with bad_file if
  /// the file cannot be read.
  [[nodiscard]] Result<void> go_back(std::uint64_t to);

  /// Returns the present position in bytes.
  [[nodiscard]] std::uint64_t position() const { return position_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Returns true for a gzip file.
  [[nodiscard]] bool is_packed() const { return gunzip_.has_value(); }

 private:
  explicit Bytes(RegularFile file, std::string name) : name_(std::move(name)), file_(std::move(file)) {}
  [[nodiscard]] Fault read_fault() const;
  [[nodiscard]] Result<void> seek(std::uint64_t byte);
  [[nodiscard]] Result<std::size_t> read(char* to, std::size_t capacity);
  [[nodiscard]] Result<void> read_more(std::size_t count);

  std::string name_;
  RegularFile file_{};
  std::optional<Gunzip> gunzip_{};  ///< for a gzip file
  std::string buffer_{};
  /// The unread part of the buffer or of the text in memory.
  std::string_view unread_{};
  std::uint64_t position_{};
  /// The end of the file is in the buffer or was passed.
  bool at_end_ = false;
};

}  // namespace gyrotherm::exchange
