// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/site_overview.hpp"

#include <gtest/gtest.h>

namespace gyrotherm::monitor {
namespace {

TEST(OneLineReason, JoinsLinesAndTrimsTheEnd) {
  EXPECT_EQ(one_line_reason("ended with 4: permission denied for schema gyrotherm."),
            "ended with 4: permission denied for schema gyrotherm");
  EXPECT_EQ(one_line_reason("connection to server on socket \"/run/a\" failed: No such file\n\tIs the server running "
                            "locally and accepting connections on that socket?\n"),
            "connection to server on socket \"/run/a\" failed: No such file; Is the server running locally and "
            "accepting connections on that socket");
  EXPECT_EQ(one_line_reason("a.\r\n\n  b;\n"), "a; b");
  EXPECT_EQ(one_line_reason("no reply in 20 s"), "no reply in 20 s");
  EXPECT_EQ(one_line_reason("?\n.\n"), "");
  EXPECT_EQ(one_line_reason(""), "");
}

}  // namespace
}  // namespace gyrotherm::monitor
