#include "acquisition/record/log_check.hpp"

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

namespace gyrotherm {
namespace {

using Bytes = std::span<const unsigned char>;

constexpr std::size_t kHeader = 32, kFrameHeader = 24;
constexpr std::size_t kSummedOfHeader = 24, kSummedOfFrameHeader = 8;
constexpr std::size_t kPageSizeAt = 8, kSaltsAt = 16, kFrameSaltsAt = 8, kSalts = 8;
constexpr std::uint32_t kMagic = 0x377F0682 | (std::endian::native == std::endian::big ? 1U : 0U);
constexpr std::uint32_t kLargestPage = 65536;

std::uint32_t big_endian(Bytes at) {
  return std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 | std::uint32_t{at[2]} << 8 | at[3];
}

std::uint32_t native(Bytes at) {
  std::uint32_t word = 0;
  std::memcpy(&word, at.data(), sizeof word);
  return word;
}

/// The sum of all that was added, in words of four bytes, two at a time.
class LogSum {
 public:
  void add(Bytes bytes) {
    for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
      first_ += native(bytes.subspan(at)) + second_;
      second_ += native(bytes.subspan(at + 4)) + first_;
    }
  }
  [[nodiscard]] bool is(Bytes stored) const {
    return big_endian(stored) == first_ && big_endian(stored.subspan(4)) == second_;
  }

 private:
  std::uint32_t first_ = 0, second_ = 0;
};

bool read(int descriptor, std::vector<unsigned char>& into, std::size_t at) {
  return ::pread(descriptor, into.data(), into.size(), static_cast<off_t>(at)) == static_cast<ssize_t>(into.size());
}

bool same(Bytes one, Bytes other) { return std::ranges::equal(one, other); }

}  // namespace

bool log_is_whole(int descriptor, std::int64_t frames) {
  std::vector<unsigned char> header(kHeader);
  if (frames == 0) return true;
  if (!read(descriptor, header, 0) || big_endian(header) != kMagic) return false;
  const Bytes head(header);
  const auto page = big_endian(head.subspan(kPageSizeAt));
  LogSum sum;
  sum.add(head.first(kSummedOfHeader));
  if (page == 0 || page > kLargestPage || !sum.is(head.subspan(kSummedOfHeader))) return false;
  std::vector<unsigned char> text(kFrameHeader + page);
  const Bytes frame(text);
  for (std::int64_t i = 0; i < frames; ++i) {
    if (!read(descriptor, text, kHeader + static_cast<std::size_t>(i) * text.size())) return false;
    if (!same(frame.subspan(kFrameSaltsAt, kSalts), head.subspan(kSaltsAt, kSalts))) return false;
    sum.add(frame.first(kSummedOfFrameHeader));
    sum.add(frame.subspan(kFrameHeader));
    if (!sum.is(frame.subspan(kFrameSaltsAt + kSalts))) return false;
  }
  return true;
}

}  // namespace gyrotherm
