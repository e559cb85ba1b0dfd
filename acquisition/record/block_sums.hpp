/// Sums of a file's bytes, a block each, by which it is seen whether they are still what they were. After a write into
/// some places of a large file only the blocks there are summed anew.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gyrotherm {

class BlockSums {
 public:
  /// Of the first `length` bytes of an open file.
  [[nodiscard]] static BlockSums of(int descriptor, std::int64_t length);

  /// The file was written to at these offsets, and now has `length` bytes; also where it grew.
  void renew(int descriptor, std::int64_t length, std::span<const std::int64_t> offsets);
  bool operator==(const BlockSums&) const = default;

 private:
  void sum_block(int descriptor, std::int64_t block);

  std::int64_t length_ = 0;
  std::vector<std::uint64_t> sums_;  ///< that anything but intent changes; 0 of a block that cannot be read
};

}  // namespace gyrotherm
