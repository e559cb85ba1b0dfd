#include "acquisition/record/block_sums.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace gyrotherm {
namespace {

constexpr std::int64_t kBlock = 65536;

std::int64_t blocks_of(std::int64_t length) { return (length + kBlock - 1) / kBlock; }

}  // namespace

/// FNV-1a over words of eight bytes.
void BlockSums::sum_block(int descriptor, std::int64_t block) {
  constexpr std::uint64_t kStart = 0xCBF29CE484222325U, kPrime = 0x100000001B3U;
  std::array<std::uint64_t, kBlock / sizeof(std::uint64_t)> words{};
  const auto size = std::min(length_ - block * kBlock, kBlock);
  auto& sum = sums_[static_cast<std::size_t>(block)];
  sum = 0;
  if (::pread(descriptor, words.data(), static_cast<std::size_t>(size), block * kBlock) != size) return;
  sum = kStart;
  for (const auto word : words) {
    sum = (sum ^ word) * kPrime;
    sum ^= sum >> 32;  // what is in the upper half counts below, too
  }
}

void BlockSums::renew(int descriptor, std::int64_t length, std::span<const std::int64_t> offsets) {
  const auto from = std::min(length_, length) / kBlock;
  length_ = length;
  sums_.resize(static_cast<std::size_t>(blocks_of(length)));
  std::vector<std::int64_t> blocks;
  for (const auto offset : offsets)
    if (offset < length) blocks.push_back(offset / kBlock);
  for (auto block = from; block < blocks_of(length); ++block) blocks.push_back(block);
  std::ranges::sort(blocks);
  const auto [last, end] = std::ranges::unique(blocks);
  blocks.erase(last, end);
  for (const auto block : blocks) sum_block(descriptor, block);
}

BlockSums BlockSums::of(int descriptor, std::int64_t length) {
  BlockSums sums;
  sums.renew(descriptor, length, {});
  return sums;
}

}  // namespace gyrotherm
