// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/web_server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "apps/monitor/http_message.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"
#include "core/tcp_listener.hpp"
#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

constexpr std::size_t kThreads = 32;
/// Largest number of connections that wait for a thread.
constexpr int kMaxWaiting = 32;
/// Longest time from the first byte of a request to its last.
constexpr auto kHeadTimeout = 1s;
constexpr auto kWriteTimeout = 5s;

}  // namespace

class WebServer::ServerThreads {
 public:
  ServerThreads(const WebServerOptions& given, Answer answer) : options(given), answer_(std::move(answer)) {}

  void serve() {
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < kThreads; ++i)
      threads.emplace_back([this] {
        block_signals();
        while (auto socket = wait_for_connection()) serve_connection(std::move(*socket));
      });
    while (!stopping) {
      if (!wait_until_ready(listener.number(), POLLIN, Deadline(1s)) || stopping) continue;
      auto socket = accept_connection(listener);
      // Waits if no descriptor is free.
      if (!socket.is_open() && !would_block()) std::this_thread::sleep_for(10ms);
      const std::lock_guard lock(mutex_);
      if (!socket.is_open() || waiting_.size() >= std::size_t{kMaxWaiting}) continue;
      waiting_.push_back(std::move(socket));
      change_.notify_one();
    }
    {
      const std::lock_guard lock(mutex_);
      change_.notify_all();
    }
    for (auto& thread : threads) thread.join();
  }

  WebServerOptions options;
  Descriptor listener;
  std::atomic<bool> stopping{false};

 private:
  /// Waits for a connection. Returns nothing once the server stops.
  std::optional<Descriptor> wait_for_connection() {
    std::unique_lock lock(mutex_);
    change_.wait(lock, [&] { return stopping || !waiting_.empty(); });
    if (stopping) return std::nullopt;
    auto socket = std::move(waiting_.front());
    waiting_.pop_front();
    return socket;
  }

  [[nodiscard]] bool has_waiting() {
    const std::lock_guard lock(mutex_);
    return !waiting_.empty();
  }

  /// Serves a connection until it ends. If memory is exhausted, only this connection ends.
  void serve_connection(Descriptor socket) {
    try {
      Connection connection(std::move(socket), options.tls);
      if (!connection.perform_handshake(kHeadTimeout)) return;
      std::string bytes;
      for (int i = 0; i < kMaxRequests && !stopping && wait_for_request(connection, bytes, i == 0); ++i)
        if (!serve_request(connection, bytes)) break;
      connection.shut_down_sending();
    } catch (const std::exception&) {
      return;
    }
  }

  /// Waits for the next request. Returns false if the connection must end: the time is over, the server stops, or
  /// another connection waits for a thread and this one has been served before.
  bool wait_for_request(const Connection& connection, const std::string& bytes, bool is_first) {
    if (!bytes.empty()) return true;
    const Deadline deadline(is_first ? Duration(kHeadTimeout) : Duration(kIdleTimeout));
    while (!deadline.has_passed()) {
      if (connection.wait_until_readable(50ms)) return true;
      if (stopping || (!is_first && has_waiting())) return false;
    }
    return false;
  }

  /// Reads a request and answers it. Returns whether the connection continues. Leaves the bytes of the next request in
  /// `bytes`.
  bool serve_request(Connection& connection, std::string& bytes) {
    const Deadline deadline{Duration(kHeadTimeout)};
    std::optional<std::size_t> end;
    while (!(end = find_head_end(bytes)) && bytes.size() <= kMaxHeadBytes)
      if (!read_more(connection, bytes, deadline))
        return bytes.empty() ? false : refuse(connection, {408, "the request was not complete in time"});
    if (!end || *end > kMaxHeadBytes) return refuse(connection, {431, "the head is too long"});
    auto read = read_head(std::string_view(bytes).substr(0, *end));
    const bool expects_body = !bytes.starts_with("HEAD ");
    bytes.erase(0, *end);
    if (const auto* refused = std::get_if<HeadRefusal>(&read)) return refuse(connection, *refused, expects_body);
    WebRequest request{.head = std::move(std::get<RequestHead>(read)),
                       .body = {},
                       .peer = connection.peer(),
                       .secure = options.tls != nullptr};
    if (!is_host(request.head.header("host")))
      return refuse(connection, {421, "unknown Host header; allow the name with --host"});
    while (bytes.size() < request.head.body_size)
      if (!read_more(connection, bytes, deadline))
        return refuse(connection, {408, "the request was not complete in time"});
    request.body = bytes.substr(0, request.head.body_size);
    bytes.erase(0, request.head.body_size);
    if (options.behind_proxy) apply_proxy_headers(request);
    return send_answer(connection, compute_answer(request), request.head);
  }

  static bool read_more(Connection& connection, std::string& bytes, const Deadline& deadline) {
    std::array<char, 4096> some{};
    const auto size = connection.read(some.data(), some.size(), deadline.left());
    bytes.append(some.data(), size);
    return size > 0;
  }

  /// Sends a refusal, without a body if the request was a HEAD. Returns false, because the connection then ends.
  static bool refuse(Connection& connection, const HeadRefusal& refused, bool with_body = true) {
    auto answer = refusal(refused.status, refused.reason);
    if (refused.status == 405) answer.headers.emplace_back("Allow", "GET, POST");
    if (connection.write(answer_head(answer, {}) + (with_body ? answer.body : ""), kWriteTimeout)) drain(connection);
    return false;
  }

  /// Reads and discards what the client still sends, for at most 100 ms. If unread bytes remained, the kernel would
  /// reset the connection, and the client could lose the answer.
  static void drain(Connection& connection) {
    connection.shut_down_sending();
    const Deadline deadline(100ms);
    std::array<char, 4096> some{};
    for (int i = 0; i < 16 && connection.read(some.data(), some.size(), deadline.left()) > 0; ++i) {
    }
  }

  WebAnswer compute_answer(const WebRequest& request) {
    try {
      return answer_(request);
    } catch (const std::exception&) {
      return refusal(500, "internal error of the monitor");
    }
  }

  /// Sends an answer. Returns whether the connection continues. A stream ends when the server stops.
  bool send_answer(Connection& connection, const WebAnswer& answer, const RequestHead& request) {
    const auto write = [&](std::string_view bytes) { return connection.write(bytes, kWriteTimeout); };
    if (!write(answer_head(answer, request))) return false;
    if (!answer.stream) return write(answer.body) && request.keep_alive;
    const bool in_chunks = is_chunked(answer, request), has_size = answer.stream_size > 0;
    std::uint64_t sent = 0;
    bool is_accepted = true;
    const bool is_complete = answer.stream([&](std::string_view piece) {
      sent += piece.size();
      is_accepted = is_accepted && !stopping && (has_size ? sent <= answer.stream_size : connection.is_connected());
      if (!piece.empty()) is_accepted = is_accepted && (in_chunks ? write(encode_chunk(piece)) : write(piece));
      return is_accepted;
    });
    if (!is_complete || !is_accepted || (has_size && sent < answer.stream_size)) return false;
    return (!in_chunks || write(encode_chunk({}))) && request.keep_alive;
  }

  [[nodiscard]] bool is_host(const std::string& host) const {
    return std::ranges::find(options.hosts, to_lower_case(host)) != options.hosts.end();
  }

  /// Replaces the peer by the client's address, which the proxy has appended to X-Forwarded-For.
  static void apply_proxy_headers(WebRequest& request) {
    const auto chain = request.head.header("x-forwarded-for");
    const auto comma = chain.rfind(',');
    const auto last = trimmed(std::string_view(chain).substr(comma == std::string::npos ? 0 : comma + 1));
    if (!last.empty() && last.size() <= 45) request.peer = last;
    request.secure = request.head.header("x-forwarded-proto") == "https";
  }

  Answer answer_;
  std::mutex mutex_;
  std::condition_variable change_;
  std::deque<Descriptor> waiting_;
};

WebServer::WebServer(const WebServerOptions& options, Answer answer)
    : server_threads_(std::make_unique<ServerThreads>(options, std::move(answer))) {}
WebServer::~WebServer() = default;

Result<int> WebServer::bind() {
  auto& options = server_threads_->options;
  auto listener = listen_on_tcp(options.address, static_cast<std::uint16_t>(options.port), kMaxWaiting);
  if (!listener)
    return failure(FaultKind::storage, fmt::format("{}:{}", options.address, options.port),
                   "cannot listen: the port is in use, or the address does not belong to this machine");
  server_threads_->listener = std::move(*listener);
  const int port = listening_port(server_threads_->listener);
  std::vector<std::string> hosts;
  const bool is_ipv6 = options.address.find(':') != std::string::npos;
  auto names = options.hosts;
  names.push_back(is_ipv6 ? fmt::format("[{}]", options.address) : options.address);
  if (options.address == "127.0.0.1" || options.address == "::1") names.emplace_back("localhost");
  for (const auto& name : names) {
    hosts.push_back(to_lower_case(fmt::format("{}:{}", name, port)));
    if (options.behind_proxy || port == (options.tls ? 443 : 80)) hosts.push_back(to_lower_case(name));
  }
  options.hosts = std::move(hosts);
  return port;
}

void WebServer::serve() { server_threads_->serve(); }

void WebServer::stop() {
  server_threads_->stopping = true;
  // Wakes serve().
  ::shutdown(server_threads_->listener.number(), SHUT_RDWR);
}

bool WebServer::is_stopping() const { return server_threads_->stopping; }

}  // namespace gyrotherm::monitor
