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
  return Bytes(std::move(*file), path);
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
  } else if (::lseek(file_.descriptor.number(), static_cast<off_t>(to), SEEK_SET) < 0) {
    return failure(FaultKind::bad_file, name_, std::string("cannot be read: ") + std::strerror(errno));
  } else {
    ahead_ = {};
    at_end_ = false;
  }
  passed_ = to;
  return {};
}

Result<void> Bytes::read_more(std::size_t count) {
  std::size_t held = ahead_.size();
  if (held > 0) std::memmove(buffer_.data(), ahead_.data(), held);
  buffer_.resize(std::max(count, kPiece));
  while (held < buffer_.size()) {
    const auto read = ::read(file_.descriptor.number(), buffer_.data() + held, buffer_.size() - held);
    if (read < 0 && errno == EINTR) continue;
    if (read < 0) return failure(FaultKind::bad_file, name_, std::string("cannot be read: ") + std::strerror(errno));
    if (read == 0) {
      at_end_ = true;
      break;
    }
    held += static_cast<std::size_t>(read);
  }
  ahead_ = std::string_view(buffer_).substr(0, held);
  return {};
}

}  // namespace gyrotherm::exchange
