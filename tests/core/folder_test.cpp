#include "core/folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace gyrotherm {
namespace {

TEST(EntriesOf, AFolderAreWhatLiesInIt) {
  const auto entries = entries_of(GYROTHERM_SOURCE_DIR "/core");
  EXPECT_NE(std::find(entries.begin(), entries.end(), std::filesystem::path(GYROTHERM_SOURCE_DIR "/core/folder.hpp")),
            entries.end());
}

TEST(EntriesOf, WhatIsNoFolderAreNone) {
  EXPECT_TRUE(entries_of("/nonexistent").empty());
  EXPECT_TRUE(entries_of("/etc/passwd").empty());
}

}  // namespace
}  // namespace gyrotherm
