// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/bytes.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

namespace gyrotherm::exchange {

namespace {

constexpr std::size_t kPieceBytes = 1 << 20;
constexpr std::string_view kMagic("\x1F\x8B", 2);
constexpr std::size_t kPackedPieceBytes = 1 << 16;
constexpr int kGzipOnly = 16 + MAX_WBITS;  // zlib's windowBits

bool is_gzip(std::string_view beginning) { return beginning.starts_with(kMagic); }

}  // namespace

/// The packed file and the state of zlib.
struct Gunzip::Stream {
  Stream(int file, std::string_view file_name) : descriptor(file), name(file_name), packed(kPackedPieceBytes) {
    is_ready = ::inflateInit2(&state, kGzipOnly) == Z_OK;
  }
  ~Stream() { ::inflateEnd(&state); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  [[nodiscard]] Result<std::size_t> fault(const std::string& what) const {
    return failure(FaultKind::bad_file, name, what);
  }
  [[nodiscard]] std::uint64_t position() const { return read_bytes - state.avail_in; }

  /// Reads the next piece of the packed file after the unread remainder of the last one. Returns false at its end.
  Result<bool> read_more() {
    std::copy_n(state.next_in, state.avail_in, packed.data());
    state.next_in = packed.data();
    const auto read = read_some(descriptor, packed.data() + state.avail_in, packed.size() - state.avail_in);
    if (read < 0) return failure(FaultKind::bad_file, name, std::string("cannot be read: ") + std::strerror(errno));
    read_bytes += static_cast<std::uint64_t>(read);
    state.avail_in += static_cast<unsigned>(read);
    return read > 0;
  }

  /// Begins the next member. Returns false if there is none: at the end, or before padding zeros.
  Result<bool> next_member() {
    while (state.avail_in < kMagic.size()) {
      const auto more = read_more();
      if (!more) return failure(more.error());
      if (!*more) break;
    }
    const std::string_view next(reinterpret_cast<const char*>(state.next_in), state.avail_in);
    if (is_gzip(next)) return ::inflateReset(&state) == Z_OK;
    if (next.find_first_not_of('\0') == std::string_view::npos) return false;
    return failure(FaultKind::bad_file, name,
                   fmt::format("gzip: other data follows at byte {}; unpack it first, \"gunzip -c FILE > "
                               "table\" keeps the data before it",
                               position()));
  }

  int descriptor;
  std::string name;
  std::vector<Bytef> packed;
  z_stream state{};
  std::uint64_t read_bytes{};
  bool is_ready = false, is_at_end = false;
};

Gunzip::Gunzip(int descriptor, std::string_view name) : stream_(std::make_unique<Stream>(descriptor, name)) {}
Gunzip::~Gunzip() = default;
Gunzip::Gunzip(Gunzip&&) noexcept = default;
Gunzip& Gunzip::operator=(Gunzip&&) noexcept = default;

Result<std::size_t> Gunzip::read(char* to, std::size_t capacity) {
  auto& state = stream_->state;
  if (!stream_->is_ready) return stream_->fault("gzip: no memory to unpack it");
  const auto most = std::min<std::size_t>(capacity, std::numeric_limits<unsigned>::max());
  state.next_out = reinterpret_cast<Bytef*>(to);
  state.avail_out = static_cast<unsigned>(most);
  while (state.avail_out == most && most > 0 && !stream_->is_at_end) {
    if (state.avail_in == 0)
      if (const auto more = stream_->read_more(); !more) return failure(more.error());
    const int code = ::inflate(&state, Z_NO_FLUSH);
    if (code == Z_STREAM_END) {
      const auto another = stream_->next_member();
      if (!another) return failure(another.error());
      stream_->is_at_end = !*another;
    } else if (code == Z_BUF_ERROR) {
      return stream_->fault(fmt::format("gzip: cut off after byte {}; \"gunzip -c FILE > table\" unpacks what is there",
                                        stream_->read_bytes));
    } else if (code != Z_OK) {
      return stream_->fault(
          fmt::format("gzip: damaged near byte {} ({}); \"gunzip -c FILE > table\" unpacks what comes "
                      "before",
                      stream_->position(), state.msg != nullptr ? state.msg : "no reason given"));
    }
  }
  return most - state.avail_out;
}

Result<Bytes> Bytes::open(const std::string& path) {
  auto file = open_regular_file(path);
  if (!file) return failure(file.error());
  Bytes bytes(std::move(*file), path);
  const auto beginning = bytes.peek(2);
  if (!beginning) return failure(beginning.error());
  if (!is_gzip(*beginning)) return bytes;
  if (const auto begun = bytes.seek(0); !begun) return failure(begun.error());
  bytes.gunzip_.emplace(bytes.file_.descriptor.number(), path);
  return bytes;
}

Result<std::string_view> Bytes::peek(std::size_t count) {
  if (unread_.size() < count && file_.descriptor.is_open() && !at_end_)
    if (auto read = read_more(count); !read) return failure(read.error());
  return unread_;
}

void Bytes::skip(std::size_t count) {
  assert(count <= unread_.size());
  unread_.remove_prefix(count);
  position_ += count;
}

Result<void> Bytes::go_back(std::uint64_t to) {
  assert(to <= position_);
  if (!file_.descriptor.is_open()) {
    const auto back = static_cast<std::size_t>(position_ - to);
    unread_ = {unread_.data() - back, unread_.size() + back};
    position_ = to;
    return {};
  }
  if (!gunzip_) return seek(to);
  if (const auto begun = seek(0); !begun) return begun;
  gunzip_.emplace(file_.descriptor.number(), name_);
  while (position_ < to) {
    if (const auto more = peek(1); !more) return failure(more.error());
    if (unread_.empty()) return failure(FaultKind::bad_file, name_, "became shorter while it was read");
    skip(std::min<std::size_t>(unread_.size(), to - position_));
  }
  return {};
}

/// Returns the bad_file fault of a failed read, with the present value of errno.
Fault Bytes::read_fault() const {
  return {FaultKind::bad_file, name_, std::string("cannot be read: ") + std::strerror(errno)};
}

/// Moves to a position of the file and drops the buffered bytes.
Result<void> Bytes::seek(std::uint64_t byte) {
  if (::lseek(file_.descriptor.number(), static_cast<off_t>(byte), SEEK_SET) < 0) return failure(read_fault());
  unread_ = {};
  at_end_ = false;
  position_ = byte;
  return {};
}

Result<std::size_t> Bytes::read(char* to, std::size_t capacity) {
  if (gunzip_) return gunzip_->read(to, capacity);
  const auto read = read_some(file_.descriptor.number(), to, capacity);
  if (read < 0) return failure(read_fault());
  return static_cast<std::size_t>(read);
}

Result<void> Bytes::read_more(std::size_t count) {
  std::size_t held = unread_.size();
  if (held > 0) std::memmove(buffer_.data(), unread_.data(), held);
  buffer_.resize(std::max(count, kPieceBytes));
  while (held < buffer_.size() && !at_end_) {
    const auto more = read(buffer_.data() + held, buffer_.size() - held);
    if (!more) return failure(more.error());
    at_end_ = *more == 0;
    held += *more;
  }
  unread_ = std::string_view(buffer_).substr(0, held);
  return {};
}

}  // namespace gyrotherm::exchange
