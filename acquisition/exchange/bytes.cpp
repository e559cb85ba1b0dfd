// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/bytes.hpp"

#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>

namespace gyrotherm::exchange {

namespace {

constexpr std::size_t kPiece = 1 << 20;

}  // namespace

Result<Bytes> Bytes::open(const std::string& path) {
  auto file = open_regular_file(path);
  if (!file) return failure(file.error());
  Bytes bytes(std::move(*file), path);
  const auto beginning = bytes.ahead(2);
  if (!beginning) return failure(beginning.error());
  if (!is_gzip(*beginning)) return bytes;
  if (const auto begun = bytes.begin_at(0); !begun) return failure(begun.error());
  bytes.gunzip_.emplace(bytes.file_.descriptor.number(), path);
  return bytes;
}

Result<std::string_view> Bytes::ahead(std::size_t count) {
  if (ahead_.size() < count && file_.descriptor.is_open() && !at_end_)
    if (auto read = read_more(count); !read) return failure(read.error());
  return ahead_;
}

void Bytes::pass(std::size_t count) {
  assert(count <= ahead_.size());
  ahead_.remove_prefix(count);
  passed_ += count;
}

Result<void> Bytes::go_back(std::uint64_t to) {
  assert(to <= passed_);
  if (!file_.descriptor.is_open()) {
    const auto back = static_cast<std::size_t>(passed_ - to);
    ahead_ = {ahead_.data() - back, ahead_.size() + back};
    passed_ = to;
    return {};
  }
  if (!gunzip_) return begin_at(to);
  if (const auto begun = begin_at(0); !begun) return begun;
  gunzip_.emplace(file_.descriptor.number(), name_);
  while (passed_ < to) {
    if (const auto more = ahead(1); !more) return failure(more.error());
    if (ahead_.empty()) return failure(FaultKind::bad_file, name_, "has become shorter while it was read");
    pass(std::min<std::size_t>(ahead_.size(), to - passed_));
  }
  return {};
}

/// Returns the fault that errno names.
Fault Bytes::unreadable() const {
  return {FaultKind::bad_file, name_, std::string("cannot be read: ") + std::strerror(errno)};
}

/// Moves to a byte of the file and drops what was read ahead.
Result<void> Bytes::begin_at(std::uint64_t byte) {
  if (::lseek(file_.descriptor.number(), static_cast<off_t>(byte), SEEK_SET) < 0) return failure(unreadable());
  ahead_ = {};
  at_end_ = false;
  passed_ = byte;
  return {};
}

Result<std::size_t> Bytes::read(char* to, std::size_t room) {
  if (gunzip_) return gunzip_->read(to, room);
  ssize_t read = -1;
  do read = ::read(file_.descriptor.number(), to, room);
  while (read < 0 && errno == EINTR);
  if (read < 0) return failure(unreadable());
  return static_cast<std::size_t>(read);
}

Result<void> Bytes::read_more(std::size_t count) {
  std::size_t held = ahead_.size();
  if (held > 0) std::memmove(buffer_.data(), ahead_.data(), held);
  buffer_.resize(std::max(count, kPiece));
  while (held < buffer_.size() && !at_end_) {
    const auto more = read(buffer_.data() + held, buffer_.size() - held);
    if (!more) return failure(more.error());
    at_end_ = *more == 0;
    held += *more;
  }
  ahead_ = std::string_view(buffer_).substr(0, held);
  return {};
}

}  // namespace gyrotherm::exchange
