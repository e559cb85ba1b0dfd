// SPDX-License-Identifier: Apache-2.0
/// The bytes of a file of any size, a piece of them in memory at a time. A gzip file is unpacked on the way.
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

/// Unpacks a gzip file (RFC 1952) from its first byte to its last, by zlib. Members that follow each other make one
/// content. Holds a piece of it in memory, however large the content is.
class Gunzip {
 public:
  /// Takes an open descriptor at the file's first byte. The descriptor must outlive this. `name` stands for the file in
  /// faults.
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

/// Goes from the first byte of a file to its last.
class Bytes {
 public:
  /// Fails as open_regular_file() does, and with bad_file if the file cannot be read.
  [[nodiscard]] static Result<Bytes> open(const std::string& path);
  /// Goes through a text that outlives this; `name` stands for its file in faults.
  Bytes(std::string_view all, std::string name) : name_(std::move(name)), ahead_(all) {}

  /// What comes next: at least `count` bytes, fewer only where the file ends. The view is good until the next call.
  /// Fails with bad_file if the file cannot be read or unpacked.
  [[nodiscard]] Result<std::string_view> ahead(std::size_t count);
  /// Goes on by so many bytes, which ahead() has shown.
  void pass(std::size_t count);
  /// Goes back to where so many bytes were passed; a gzip file is unpacked again from its start. Fails with bad_file if
  /// the file cannot be read.
  [[nodiscard]] Result<void> go_back(std::uint64_t to);

  /// Bytes that were passed.
  [[nodiscard]] std::uint64_t passed() const { return passed_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Returns true for a gzip file.
  [[nodiscard]] bool is_packed() const { return gunzip_.has_value(); }

 private:
  explicit Bytes(RegularFile file, std::string name) : name_(std::move(name)), file_(std::move(file)) {}
  [[nodiscard]] Fault unreadable() const;
  [[nodiscard]] Result<void> begin_at(std::uint64_t byte);
  [[nodiscard]] Result<std::size_t> read(char* to, std::size_t room);
  [[nodiscard]] Result<void> read_more(std::size_t count);

  std::string name_;
  RegularFile file_{};
  std::optional<Gunzip> gunzip_{};  ///< of a gzip file
  std::string buffer_{};
  std::string_view ahead_{};  ///< of the buffer, or of the text in memory
  std::uint64_t passed_{};
  bool at_end_ = false;  ///< all of the file is in the buffer or passed
};

}  // namespace gyrotherm::exchange
