#include "acquisition/record/row_chain.hpp"

#include <bit>
#include <cmath>
#include <cstring>

namespace gyrotherm {

void RowChain::begin(std::string_view table) {
  row_.assign(reinterpret_cast<const char*>(head_.data()), head_.size());
  add(table);
}

void RowChain::add_bits(char type, std::uint64_t bits) {
  static_assert(std::endian::native == std::endian::little, "the bytes of a number are hashed least first");
  char bytes[1 + sizeof bits];
  bytes[0] = type;
  std::memcpy(bytes + 1, &bits, sizeof bits);
  row_.append(bytes, sizeof bytes);
}

void RowChain::add_integer(std::int64_t value) { add_bits('i', static_cast<std::uint64_t>(value)); }

void RowChain::add(double value) {
  constexpr double kLargest = 9.2e18;  // of SQLite's integers, about
  if (std::isnan(value)) return add_null();
  if (std::abs(value) < kLargest && value == std::floor(value)) return add_integer(static_cast<std::int64_t>(value));
  add_bits('r', std::bit_cast<std::uint64_t>(value));
}

void RowChain::add(std::string_view value) {
  add_bits('t', value.size());
  row_ += value;
}

void RowChain::add_null() { row_ += 'n'; }

std::int64_t RowChain::end() {
  Sha256 hash;
  hash.add(row_);
  head_ = hash.digest();
  std::int64_t beginning{};
  std::memcpy(&beginning, head_.data(), sizeof beginning);
  return beginning;
}

}  // namespace gyrotherm
