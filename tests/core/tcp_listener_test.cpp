// SPDX-License-Identifier: Apache-2.0
#include "core/tcp_listener.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "core/deadline.hpp"

namespace gyrotherm {
namespace {

Descriptor connect_to_loopback(std::uint16_t port) {
  Descriptor client(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(client.number(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  return client;
}

TEST(TcpListener, AcceptsPendingConnection) {
  const auto listener = listen_on_tcp("127.0.0.1", 0, 1);
  ASSERT_TRUE(listener) << text(listener.error());
  EXPECT_FALSE(accept_connection(*listener).is_open());
  EXPECT_TRUE(would_block());
  const auto client = connect_to_loopback(listening_port(*listener));
  ASSERT_TRUE(wait_until_ready(listener->number(), POLLIN, Deadline(std::chrono::seconds(10))));
  const auto accepted = accept_connection(*listener);
  ASSERT_TRUE(accepted.is_open());
  ASSERT_EQ(::send(client.number(), "x", 1, 0), 1);
  ASSERT_TRUE(wait_until_ready(accepted.number(), POLLIN, Deadline(std::chrono::seconds(10))));
  char byte = 0;
  EXPECT_EQ(read_some(accepted.number(), &byte, 1), 1);
  EXPECT_EQ(byte, 'x');
}

TEST(TcpListener, FailsWhenPortIsTaken) {
  const auto first = listen_on_tcp("127.0.0.1", 0, 1);
  ASSERT_TRUE(first) << text(first.error());
  const auto second = listen_on_tcp("127.0.0.1", listening_port(*first), 1);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, FaultKind::disconnected);
}

TEST(TcpListener, FailsWhenAddressIsNotOfThisMachine) {
  const auto listener = listen_on_tcp("192.0.2.1", 0, 1);  // RFC 5737: documentation only
  ASSERT_FALSE(listener);
  EXPECT_EQ(listener.error().kind, FaultKind::disconnected);
}

}  // namespace
}  // namespace gyrotherm
