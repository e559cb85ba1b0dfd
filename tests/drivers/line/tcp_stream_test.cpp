// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <string>

#include "drivers/line/byte_streams.hpp"
#include "tests/support/fakes.hpp"
#include "tests/support/loopback_server.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
constexpr Duration kSoon = milliseconds(60), kPatient = milliseconds(2000);

Answer echo(std::span<const std::byte> request) { return {{request.begin(), request.end()}}; }

Result<std::string> exchange(ByteStream& stream, std::string_view text, Duration within) {
  if (auto sent = stream.write(tests::bytes_of(text), within); !sent) return failure(sent.error());
  std::array<std::byte, 256> buffer;
  const auto size = stream.read(buffer, within);
  if (!size) return failure(size.error());
  return std::string(reinterpret_cast<const char*>(buffer.data()), *size);
}

TEST(TcpStream, CarriesBytesBothWays) {
  const LoopbackServer server(echo);
  const auto stream = make_tcp_stream(server.address(), kPatient);
  EXPECT_EQ(exchange(*stream, "CRDG? 0\r\n", kPatient).value(), "CRDG? 0\r\n");
  EXPECT_EQ(exchange(*stream, "again", kPatient).value(), "again");
  EXPECT_EQ(server.connections(), 1);
}

TEST(TcpStream, TimesOutWithoutEndWhenPeerIsSilent) {
  const LoopbackServer server([](auto request) { return request.size() == 1 ? Answer{} : echo(request); });
  const auto stream = make_tcp_stream(server.address(), kPatient);
  EXPECT_EQ(exchange(*stream, "?", kSoon).error().kind, FaultKind::timeout);
  EXPECT_EQ(exchange(*stream, "hello", kPatient).value(), "hello");
  EXPECT_EQ(server.connections(), 1);
}

TEST(TcpStream, KeepsWaitingAfterSignal) {
  struct sigaction notice {
  }, before{};
  notice.sa_handler = [](int) {};
  sigaction(SIGUSR1, &notice, &before);
  const auto reader = pthread_self();
  const LoopbackServer server([reader](auto request) {
    for (int i = 0; i < 5; ++i) pthread_kill(reader, SIGUSR1);
    return echo(request);
  });
  const auto stream = make_tcp_stream(server.address(), kPatient);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(exchange(*stream, "CRDG? 0\r\n", kPatient).value_or("cut off"), "CRDG? 0\r\n");
  sigaction(SIGUSR1, &before, nullptr);
}

TEST(TcpStream, ConnectsAgainAfterAReset) {
  const LoopbackServer server([](auto request) { return request.size() == 1 ? Answer{{}, true} : echo(request); });
  const auto stream = make_tcp_stream(server.address(), kPatient);
  EXPECT_EQ(exchange(*stream, "?", kPatient).error().kind, FaultKind::disconnected);
  EXPECT_EQ(exchange(*stream, "hello", kPatient).value(), "hello");
  EXPECT_EQ(server.connections(), 2);
}

TEST(TcpStream, RestsAfterTheSecondFailureInARow) {
  TcpLine nobody;
  {
    const LoopbackServer closed(echo);
    nobody = closed.address();
  }
  const auto stream = make_tcp_stream(nobody, kSoon);
  EXPECT_EQ(exchange(*stream, "?", kSoon).error().what, "Connection refused");
  EXPECT_EQ(exchange(*stream, "?", kSoon).error().what, "Connection refused");
  EXPECT_EQ(exchange(*stream, "?", kSoon).error().what, "Connection refused; next try in 0.5 s");
  stream->end_rest();
  EXPECT_EQ(exchange(*stream, "?", kSoon).error().what, "Connection refused") << "tried at once";
  EXPECT_EQ(exchange(*stream, "?", kSoon).error().what, "Connection refused; next try in 0.5 s") << "once";
}

}  // namespace
}  // namespace gyrotherm::drivers
