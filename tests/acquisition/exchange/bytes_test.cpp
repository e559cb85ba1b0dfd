// SPDX-License-Identifier: Apache-2.0
/// Tests that a gzip file is unpacked to its content, and that damage is a fault with its position.
#include "acquisition/exchange/bytes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/folder.hpp"

namespace gyrotherm::exchange {
namespace {

/// "t,T
/// 0,20
/// 1,21
/// ", packed with `gzip -n` of gzip 1.12.
const std::string kPacked(
    "\x1f\x8b\x08\x00\x00\x00\x00\x00\x00\x03\x2b\xd1\x09\xe1\x32\xd0\x31\x32\xe0\x32\xd4\x31\x32\xe4\x02"
    "\x00\x39\xf1\x8a\x63\x0e\x00\x00\x00",
    34);
const std::string kContent = "t,T\n0,20\n1,21\n";

std::string write_file(const tests::TestFolder& folder, const std::string& bytes) {
  const auto path = folder / "table.gz";
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/// Returns the remaining content, read in pieces of `piece` bytes.
Result<std::string> read_remainder(Bytes& bytes, std::size_t piece) {
  std::string all;
  while (true) {
    const auto ahead = bytes.peek(piece);
    if (!ahead) return failure(ahead.error());
    if (ahead->empty()) return all;
    const auto count = std::min(piece, ahead->size());
    all += ahead->substr(0, count);
    bytes.skip(count);
  }
}

Result<std::string> content(const tests::TestFolder& folder, const std::string& packed, std::size_t piece = 1000) {
  auto bytes = Bytes::open(write_file(folder, packed));
  if (!bytes) return failure(bytes.error());
  EXPECT_TRUE(bytes->is_packed());
  return read_remainder(*bytes, piece);
}

/// Packs a text with gzip.
std::string pack_with_gzip(const tests::TestFolder& folder, const std::string& text, const std::string& options = "") {
  std::ofstream(folder / "plain", std::ios::binary) << text;
  const auto command = "gzip -c " + options + " '" + (folder / "plain") + "' > '" + (folder / "made.gz") + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::ifstream file(folder / "made.gz", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Gunzip, UnpacksGoldenBytes) {
  const tests::TestFolder folder;
  for (const std::size_t piece : {1u, 3u, 1000u}) {
    const auto read = content(folder, kPacked, piece);
    ASSERT_TRUE(read) << text(read.error());
    EXPECT_EQ(*read, kContent);
  }
}

TEST(Gunzip, JoinsMembersAndSkipsPadding) {
  const tests::TestFolder folder;
  for (const auto& [packed, expected] : {std::pair(kPacked + kPacked, kContent + kContent),
                                         std::pair(kPacked + kPacked + kPacked, kContent + kContent + kContent),
                                         std::pair(kPacked + std::string(512, '\0'), kContent)}) {
    const auto read = content(folder, packed, 5);
    ASSERT_TRUE(read) << text(read.error());
    EXPECT_EQ(*read, expected);
  }
}

TEST(Gunzip, UnpacksFilesLargerThanItsPieces) {
  const tests::TestFolder folder;
  std::string large;
  std::uint64_t noise = 1;
  while (large.size() < (5 << 20))
    large += std::to_string(noise = noise * 6364136223846793005u + 1442695040888963407u) + "\n";
  for (const auto* options : {"", "-1", "-9"}) {
    const auto packed = pack_with_gzip(folder, large, options);
    for (const auto& [file, expected] : {std::pair(packed, large), std::pair(packed + packed, large + large)}) {
      const auto read = content(folder, file, 70'001);
      ASSERT_TRUE(read) << text(read.error());
      EXPECT_TRUE(*read == expected) << read->size();
    }
  }
}

TEST(Gunzip, ReturnsToEarlierPosition) {
  const tests::TestFolder folder;
  std::string large;
  for (int i = 0; i < 400'000; ++i) large += std::to_string(i) + "\n";
  auto bytes = Bytes::open(write_file(folder, pack_with_gzip(folder, large)));
  ASSERT_TRUE(bytes);
  for (const std::size_t to : {0u, 1u, 1'500'000u}) {
    ASSERT_TRUE(read_remainder(*bytes, 4096));
    ASSERT_TRUE(bytes->go_back(to));
    EXPECT_EQ(bytes->position(), to);
    EXPECT_EQ(bytes->peek(100)->substr(0, 100), std::string_view(large).substr(to, 100));
  }
}

TEST(Gunzip, RefusesTruncatedFile) {
  const tests::TestFolder folder;
  for (std::size_t size = 2; size < kPacked.size(); ++size) {
    const auto read = content(folder, kPacked.substr(0, size));
    ASSERT_FALSE(read) << size;
    EXPECT_EQ(read.error().kind, FaultKind::bad_file);
    EXPECT_NE(text(read.error()).find("cut off after byte " + std::to_string(size)), std::string::npos)
        << text(read.error());
  }
}

TEST(Gunzip, NeverReadsWrongContentFromDamagedFile) {
  const tests::TestFolder folder;
  std::size_t refused = 0;
  for (std::size_t at = 2; at < kPacked.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      auto damaged = kPacked;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      const auto read = content(folder, damaged);
      EXPECT_EQ(read.value_or(kContent), kContent) << at;  // unused bits of the header
      refused += !read;
    }
  EXPECT_GT(refused, (kPacked.size() - 10) * 8 - 1) << "all bits after the header are checked";
}

TEST(Gunzip, ReportsBytesAfterGzip) {
  const tests::TestFolder folder;
  const auto read = content(folder, kPacked + "2,22\n");
  ASSERT_FALSE(read);
  EXPECT_NE(text(read.error()).find("other data follows at byte 34"), std::string::npos) << text(read.error());
}

}  // namespace
}  // namespace gyrotherm::exchange
