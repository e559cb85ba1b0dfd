// SPDX-License-Identifier: Apache-2.0
/// Server that accepts connections and never answers.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace gyrotherm::app {

/// Listens in place of a chamber and keeps the bytes sent to it.
class Listener {
 public:
  Listener() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_TRUE(::bind(socket_, any, size) == 0 && ::listen(socket_, 8) == 0);
    ::getsockname(socket_, any, &size);
    port_ = ntohs(address.sin_port);
  }
  ~Listener() { ::close(socket_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  [[nodiscard]] int port() const { return port_; }
  /// Returns the number of bytes from the first client, which has hung up; −1 if there was none.
  [[nodiscard]] long bytes_of_first_client() const {
    const int caller = ::accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK);
    char bytes[64];
    const auto size = caller < 0 ? -1 : ::read(caller, bytes, sizeof bytes);
    ::close(caller);
    return size;
  }

 private:
  int socket_, port_{};
};

}  // namespace gyrotherm::app
