// SPDX-License-Identifier: Apache-2.0
/// A server on the loopback interface for tests of real sockets: one connection at a time, one answer per request.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <span>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "drivers/line/line_address.hpp"

namespace gyrotherm::drivers {

struct Answer {
  std::vector<std::byte> bytes;   ///< empty: no answer
  bool then_reset = false;        ///< resets the connection
  std::vector<std::byte> rest{};  ///< sent after 100 ms
};

class LoopbackServer {
 public:
  using Handler = std::function<Answer(std::span<const std::byte> request)>;

  explicit LoopbackServer(Handler handler) : handler_(std::move(handler)), listener_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof here;
    if (bind(listener_, reinterpret_cast<sockaddr*>(&here), size) != 0 || listen(listener_, 8) != 0 ||
        getsockname(listener_, reinterpret_cast<sockaddr*>(&here), &size) != 0)
      throw std::runtime_error("cannot listen on loopback");
    port_ = ntohs(here.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~LoopbackServer() {
    stopping_ = true;
    thread_.join();
    close(listener_);
  }

  [[nodiscard]] TcpLine address() const { return {"127.0.0.1", port_}; }
  [[nodiscard]] int connections() const { return connections_; }
  [[nodiscard]] int requests() const { return requests_; }

 private:
  [[nodiscard]] bool readable(int descriptor) const {
    constexpr int kLookUpEveryMs = 5;
    pollfd line{descriptor, POLLIN, 0};
    while (!stopping_)
      if (poll(&line, 1, kLookUpEveryMs) > 0) return true;
    return false;
  }

  void serve() {
    while (readable(listener_)) {
      const int connection = accept(listener_, nullptr, nullptr);
      ++connections_;
      while (readable(connection) && answer_one(connection)) {
      }
      close(connection);
    }
  }

  bool answer_one(int connection) {
    std::array<std::byte, 1024> buffer;
    const auto size = recv(connection, buffer.data(), buffer.size(), 0);
    if (size <= 0) return false;
    ++requests_;
    const auto answer = handler_(std::span(buffer).first(static_cast<std::size_t>(size)));
    if (!answer.bytes.empty()) (void)!send(connection, answer.bytes.data(), answer.bytes.size(), MSG_NOSIGNAL);
    if (!answer.rest.empty()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      (void)!send(connection, answer.rest.data(), answer.rest.size(), MSG_NOSIGNAL);
    }
    if (!answer.then_reset) return true;
    const linger at_once{1, 0};
    setsockopt(connection, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    return false;
  }

  Handler handler_;
  int listener_;
  std::uint16_t port_{};
  std::atomic<bool> stopping_ = false;
  std::atomic<int> connections_ = 0, requests_ = 0;
  std::thread thread_;
};

}  // namespace gyrotherm::drivers
