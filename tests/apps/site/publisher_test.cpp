// SPDX-License-Identifier: Apache-2.0
#include "apps/site/publisher.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::site {
namespace {

using std::chrono_literals::operator""h;

TEST(WatchedFile, IsDueUntilSentAndAfterChange) {
  const FileState before{.device = 1, .inode = 2, .changed_ns = 3, .size = 4};
  auto after = before;
  after.changed_ns = 5;
  WatchedFile file;
  EXPECT_TRUE(file.is_due(before));
  EXPECT_TRUE(file.is_due({})) << "an unreadable file is tried once";
  file.note_done(before);
  EXPECT_FALSE(file.is_due(before));
  EXPECT_TRUE(file.is_due(after));
  EXPECT_TRUE(file.is_due({}));
}

TEST(WatchedFile, IsDueAgainAfterRefusal) {
  const FileState state{.device = 1, .inode = 2, .changed_ns = 3, .size = 4};
  WatchedFile file;
  file.note_refusal(state, 1h);
  EXPECT_FALSE(file.is_due(state));
  EXPECT_TRUE(file.is_due({})) << "it has changed";
  file.note_refusal(state, Duration{});
  EXPECT_TRUE(file.is_due(state));
  file.note_done(state);
  EXPECT_FALSE(file.is_due(state));
}

}  // namespace
}  // namespace gyrotherm::site
