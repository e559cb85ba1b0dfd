// SPDX-License-Identifier: Apache-2.0
/// Sends requests to a text session of a virtual instrument.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "simulator/servers/session.hpp"

namespace gyrotherm::simulator {

[[nodiscard]] inline std::string ask(Session& session, std::string_view text) {
  std::vector<std::byte> reply;
  EXPECT_TRUE(session.feed(std::as_bytes(std::span(text)), reply));
  return {reinterpret_cast<const char*>(reply.data()), reply.size()};
}

}  // namespace gyrotherm::simulator
