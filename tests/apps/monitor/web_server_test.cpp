// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/web_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <future>
#include <new>
#include <optional>
#include <thread>

#include "apps/monitor/deliver.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

/// A server on its own thread.
class Served {
 public:
  explicit Served(WebServer::Answer answer, std::vector<std::string> hosts = {})
      : server_({.address = "127.0.0.1", .hosts = std::move(hosts)}, std::move(answer)) {
    const auto port = server_.bind();
    EXPECT_TRUE(port) << (port ? "" : text(port.error()));
    port_ = port ? *port : 0;
    thread_ = std::thread([this] { server_.serve(); });
  }
  ~Served() {
    server_.stop();
    thread_.join();
  }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  [[nodiscard]] int port() const { return port_; }
  /// Sends a request and returns the bytes received until the connection ends, or nothing if it does not end within 2
  /// s.
  [[nodiscard]] std::optional<std::string> ask(const std::string& line, const std::string& host,
                                               const std::string& headers = "Connection: close\r\n",
                                               const std::string& version = "HTTP/1.1") const {
    const Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port_));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{.tv_sec = 2, .tv_usec = 0};
    ::setsockopt(socket.number(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (::connect(socket.number(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) return std::nullopt;
    const auto sent = fmt::format("{} {}\r\nHost: {}:{}\r\n{}\r\n", line, version, host, port_, headers);
    if (::send(socket.number(), sent.data(), sent.size(), MSG_NOSIGNAL) < 0) return std::nullopt;
    std::string all;
    std::array<char, 4096> some{};
    for (;;) {
      const auto size = ::recv(socket.number(), some.data(), some.size(), 0);
      if (size < 0) return std::nullopt;
      if (size == 0) return all;
      all.append(some.data(), static_cast<std::size_t>(size));
    }
  }

 private:
  WebServer server_;
  int port_{};
  std::thread thread_;
};

WebAnswer nothing(const WebRequest& /*request*/) { return {.body = "{}"}; }

TEST(WebServer, FailsWithStorageIfPortIsUsed) {
  WebServer first({.address = "127.0.0.1"}, nothing);
  const auto port = first.bind();
  ASSERT_TRUE(port);
  WebServer second({.address = "127.0.0.1", .port = *port}, nothing);
  const auto refused = second.bind();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::storage);
}

TEST(WebServer, StopsBeforeServing) {
  WebServer server({.address = "127.0.0.1"}, nothing);
  ASSERT_TRUE(server.bind());
  std::thread stopping([&] { server.stop(); });
  std::this_thread::sleep_for(100ms);
  auto served = std::async(std::launch::async, [&] { server.serve(); });
  const bool ended = served.wait_for(5s) == std::future_status::ready;
  EXPECT_TRUE(ended);
  stopping.join();
  if (!ended) server.stop();
}

TEST(WebServer, StopsDuringLongAnswer) {
  std::promise<void> begun;
  std::future<std::optional<std::string>> reader;
  const Deadline deadline(10s);
  {
    const Served page([&](const WebRequest&) {
      WebAnswer answer;
      answer.stream = [&](const Send& send) {
        begun.set_value();
        while (send("piece by piece") && !deadline.has_passed()) std::this_thread::sleep_for(10ms);
        return true;
      };
      return answer;
    });
    reader = std::async(std::launch::async, [&] { return page.ask("GET /", "127.0.0.1"); });
    begun.get_future().wait();
  }
  EXPECT_FALSE(deadline.has_passed());
  reader.wait();
}

TEST(WebServer, ClosesConnectionAfterIncompleteAnswer) {
  const Served page([](const WebRequest& request) {
    WebAnswer answer{.stream_size = request.head.path == "/sized" ? std::uint64_t{100} : 0};
    answer.stream = [](const Send& send) { return send("half of it") && false; };
    return answer;
  });
  const auto sized = page.ask("GET /sized", "127.0.0.1", "");
  ASSERT_TRUE(sized) << "the connection stays open";
  EXPECT_TRUE(sized->ends_with("half of it")) << *sized;
  const auto unsized = page.ask("GET /unsized", "127.0.0.1", "");
  ASSERT_TRUE(unsized);
  EXPECT_EQ(unsized->find("\r\n0\r\n"), std::string::npos) << "it does not seem whole: " << *unsized;
}

TEST(WebServer, SendsNoChunksToHttp10Client) {
  const Served page([](const WebRequest&) {
    WebAnswer answer;
    answer.stream = [](const Send& send) { return send("one piece ") && send("and another"); };
    return answer;
  });
  const auto plain = page.ask("GET /", "127.0.0.1", "", "HTTP/1.0");
  ASSERT_TRUE(plain) << "the end of the connection is the end of the answer";
  EXPECT_EQ(plain->find("Transfer-Encoding"), std::string::npos) << *plain;
  EXPECT_TRUE(plain->ends_with("\r\n\r\none piece and another")) << *plain;
  const auto chunks = page.ask("GET /", "127.0.0.1").value_or("");
  EXPECT_NE(chunks.find("\r\nTransfer-Encoding: chunked\r\n"), std::string::npos) << chunks;
}

TEST(WebServer, ContinuesStreamAfterEmptyPiece) {
  const Served page([](const WebRequest&) {
    WebAnswer answer;
    answer.stream = [](const Send& send) { return send("one") && send("") && send("two"); };
    return answer;
  });
  const auto chunks = page.ask("GET /", "127.0.0.1").value_or("");
  EXPECT_TRUE(chunks.ends_with("\r\n\r\n3\r\none\r\n3\r\ntwo\r\n0\r\n\r\n")) << chunks;
}

TEST(WebServer, TruncatesAnswerAtItsSize) {
  const Served page([](const WebRequest&) {
    WebAnswer answer{.stream_size = 4};
    answer.stream = [](const Send& send) { return send("four") && send("HTTP/1.1 200 OK"); };
    return answer;
  });
  const auto sized = page.ask("GET /", "127.0.0.1", "");
  ASSERT_TRUE(sized) << "the connection stays open";
  EXPECT_TRUE(sized->ends_with("\r\n\r\nfour")) << *sized;
}

TEST(WebServer, SurvivesAnAnswerThatThrows) {
  const Served page([](const WebRequest& request) -> WebAnswer {
    if (request.head.path == "/full") throw std::bad_alloc();
    WebAnswer answer;
    if (request.head.path == "/half") answer.stream = [](const Send&) -> bool { throw std::bad_alloc(); };
    return answer;
  });
  EXPECT_TRUE(page.ask("GET /full", "127.0.0.1").value_or("").starts_with("HTTP/1.1 500 "));
  EXPECT_FALSE(page.ask("GET /half", "127.0.0.1").value_or("").ends_with("\r\n0\r\n\r\n"));
  EXPECT_TRUE(page.ask("GET /", "127.0.0.1").value_or("").starts_with("HTTP/1.1 200 "));
}

TEST(WebServer, ComparesHostsWithoutCase) {
  const Served page(nothing, {"RIG.Example.org"});
  for (const auto* host : {"rig.example.org", "RIG.Example.org", "127.0.0.1", "LOCALHOST"})
    EXPECT_TRUE(page.ask("GET /", host).value_or("").starts_with("HTTP/1.1 200 ")) << host;
  EXPECT_TRUE(page.ask("GET /", "pig.example.org").value_or("").starts_with("HTTP/1.1 421 "));
}

TEST(WebServer, ReturnsAllowedMethods) {
  const Served page(nothing);
  const auto answer = page.ask("DELETE /", "127.0.0.1").value_or("");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 405 ")) << answer;
  EXPECT_NE(answer.find("\r\nAllow: GET, POST\r\n"), std::string::npos) << answer;
  EXPECT_TRUE(answer.ends_with("}\n")) << answer;
  const auto head = page.ask("HEAD /", "127.0.0.1").value_or("");
  EXPECT_TRUE(head.starts_with("HTTP/1.1 405 ")) << head;
  EXPECT_TRUE(head.ends_with("\r\n\r\n")) << "an answer to HEAD has no body: " << head;
}

TEST(MonitorAnswers, IsFalseWhenProxyAnswersInstead) {
  const auto at = [](const Served& page) { return fmt::format("http://127.0.0.1:{}", page.port()); };
  const Served there(nothing), gone([](const WebRequest&) { return refusal(502, "bad gateway"); });
  EXPECT_TRUE(is_monitor_responding(at(there), 5s));
  EXPECT_FALSE(is_monitor_responding(at(gone), 5s));
}

}  // namespace
}  // namespace gyrotherm::monitor
