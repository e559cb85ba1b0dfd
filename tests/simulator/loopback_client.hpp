// SPDX-License-Identifier: Apache-2.0
/// Client of the virtual instruments.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gyrotherm::simulator {

/// Client that uses only sockets. Every wait ends after five seconds.
class Client {
 public:
  explicit Client(std::uint16_t port) : descriptor_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const timeval limit{5, 0};
    ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  ~Client() { ::close(descriptor_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Returns false if the other end has closed the connection.
  bool send(std::span<const std::byte> bytes) const {
    return ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL) >= 0;
  }
  bool send(std::string_view text) const { return send(std::as_bytes(std::span(text))); }
  /// Returns `size` bytes, or fewer if the connection ends before.
  [[nodiscard]] std::vector<std::byte> receive(std::size_t size) const {
    std::vector<std::byte> bytes(size);
    std::size_t got = 0;
    while (got < size) {
      const auto more = ::recv(descriptor_, bytes.data() + got, size - got, 0);
      if (more <= 0) break;
      got += static_cast<std::size_t>(more);
    }
    bytes.resize(got);
    return bytes;
  }
  [[nodiscard]] std::string receive_line() const {
    std::string line;
    while (!line.ends_with('\n')) {
      const auto byte = receive(1);
      if (byte.empty()) break;
      line.push_back(static_cast<char>(byte.front()));
    }
    return line;
  }
  [[nodiscard]] bool was_dropped() const { return receive(1).empty(); }

 private:
  int descriptor_;
};

}  // namespace gyrotherm::simulator
