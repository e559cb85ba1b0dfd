// SPDX-License-Identifier: Apache-2.0
#include "core/result.hpp"

#include <gtest/gtest.h>

namespace gyrotherm {
namespace {

TEST(Fault, HasTextThatBeginsWithLocation) {
  EXPECT_EQ(text(Fault{FaultKind::timeout, "chamber read holding 2782", "no reply in 500 ms"}),
            "chamber read holding 2782: no reply in 500 ms");
  EXPECT_EQ(text(Fault{FaultKind::usage, "", "no command"}), "no command");
}

TEST(Fault, HasNameForEveryKind) {
  for (int i = 0; i <= static_cast<int>(FaultKind::usage); ++i)
    EXPECT_STRNE(name(static_cast<FaultKind>(i)), "unknown");
}

}  // namespace
}  // namespace gyrotherm
