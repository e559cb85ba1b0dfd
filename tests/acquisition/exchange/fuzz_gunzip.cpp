// SPDX-License-Identifier: Apache-2.0
/// Unpacks any bytes. Either the content is the same for all piece sizes, or the file is refused with a position.
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "acquisition/exchange/bytes.hpp"
#include "core/file.hpp"
#include "tests/acquisition/exchange/fuzz.hpp"
#include "tests/support/fuzz_target.hpp"

namespace gyrotherm::exchange {

constexpr std::size_t kMost = 1 << 20;

/// Reads the content of a file in pieces of `piece` bytes, up to kMost. Returns false if the file is refused.
bool read_all(int file, std::size_t piece, std::string& content) {
  require(::lseek(file, 0, SEEK_SET) == 0);
  Gunzip gunzip(file, "fuzz");
  std::string part(piece, '\0');
  while (content.size() < kMost) {
    const auto read = gunzip.read(part.data(), part.size());
    if (!read) {
      require(read.error().kind == FaultKind::bad_file && read.error().where == "fuzz");
      return false;
    }
    require(*read <= piece);
    if (*read == 0) return true;
    content.append(part, 0, *read);
  }
  return true;
}

FUZZ_TARGET(gunzip, const std::uint8_t* data, std::size_t size) {
  for (const std::string& beginning : {std::string(), std::string("\x1F\x8B\x08\0\0\0\0\0\0\x03", 10)}) {
    const auto bytes = beginning + std::string(reinterpret_cast<const char*>(data), size);
    const Descriptor file(::memfd_create("fuzz", MFD_CLOEXEC));
    require(::write(file.number(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
    std::string by_ones, at_once;
    const bool read = read_all(file.number(), 1, by_ones);
    const bool read_at_once = read_all(file.number(), 100'000, at_once);
    if (by_ones.size() >= kMost) continue;  // the remainder was not read
    require(read_at_once == read && (!read || by_ones == at_once));
  }
  return 0;
}

}  // namespace gyrotherm::exchange
