// SPDX-License-Identifier: Apache-2.0
#include "core/abstract_socket.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace gyrotherm {
namespace {

TEST(AbstractSocket, NameIsShortenedOnlyIfItIsTooLong) {
  const std::string plain(70, 'a'), longer = "x" + std::string(30, 'b') + std::string(50, 'c');
  EXPECT_EQ(shorten_for_name(plain, 70), plain);
  const auto name = shorten_for_name(longer, 70);
  EXPECT_EQ(name.size(), 16U + 1 + 50);
  EXPECT_TRUE(name.ends_with("-" + std::string(50, 'c'))) << name;
  EXPECT_NE(name, shorten_for_name("y" + longer.substr(1), 70)) << "the hash is that of the whole text";
}

TEST(AbstractSocket, PeerIsTheListener) {
  const auto address = make_abstract_address("gyrotherm-test-" + std::to_string(::getpid()));
  const auto server = open_stream_socket(), client = open_stream_socket();
  EXPECT_FALSE(read_peer(kNoDescriptor));
  ASSERT_EQ(::bind(server.number(), address.pointer(), address.size), 0);
  ASSERT_EQ(::listen(server.number(), 1), 0);
  ASSERT_EQ(::connect(client.number(), address.pointer(), address.size), 0);
  const auto peer = read_peer(client.number());
  ASSERT_TRUE(peer);
  EXPECT_EQ(peer->pid, ::getpid());
  EXPECT_EQ(peer->uid, ::geteuid());
}

TEST(AbstractSocket, NameIsCutAtLengthOfAddress) {
  const auto address = make_abstract_address(std::string(200, 'n'));
  EXPECT_EQ(address.size, sizeof(sockaddr_un));
  EXPECT_EQ(address.text.sun_path[0], '\0');
}

}  // namespace
}  // namespace gyrotherm
