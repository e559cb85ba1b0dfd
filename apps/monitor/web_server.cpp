// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/web_server.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "apps/monitor/request_head.hpp"
#include "core/deadline.hpp"
#include "core/process.hpp"
#include "core/text.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

constexpr std::size_t kThreads = 32;
constexpr std::size_t kMostWaiting = 32;  ///< connections that no thread has taken; more are closed at once
constexpr auto kHeadWithin = 1s;          ///< a head, from its first byte, and its body
constexpr auto kIdle = 3s;                ///< between requests of one connection
constexpr auto kWriteWithin = 5s;
constexpr int kMostRequests = 100;  ///< of one connection

/// Whether the thread that runs a connection is to close it unheard.
thread_local bool shed = false;

/// 32 threads, and a queue with an end.
class Threads final : public httplib::TaskQueue {
 public:
  Threads() {
    for (std::size_t i = 0; i < kThreads; ++i)
      threads_.emplace_back([this] {
        block_signals();
        work();
      });
  }

  void enqueue(std::function<void()> connection) override {
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.size() < kMostWaiting) {
        waiting_.push_back(std::move(connection));
        pressure_ = waiting_.size();
        some_.notify_one();
        return;
      }
    }
    shed = true;
    connection();
    shed = false;
  }

  void shutdown() override {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
      some_.notify_all();
    }
    for (auto& thread : threads_) thread.join();
  }

  /// Whether connections wait for a thread.
  [[nodiscard]] static bool is_full() { return pressure_ > 0; }

 private:
  void work() {
    for (;;) {
      std::function<void()> connection;
      {
        std::unique_lock lock(mutex_);
        some_.wait(lock, [&] { return stopped_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        connection = std::move(waiting_.front());
        waiting_.pop_front();
        pressure_ = waiting_.size();
        shed = stopped_;
      }
      connection();
    }
  }

  std::mutex mutex_;
  std::condition_variable some_;
  std::deque<std::function<void()>> waiting_;
  std::vector<std::thread> threads_;
  bool stopped_{};
  static inline std::atomic<std::size_t> pressure_{0};
};

/// What the library sees of a connection: a request that was made here, and an outlet for the answer.
class AnswerStream final : public httplib::Stream {
 public:
  AnswerStream(Connection& connection, std::string request) : connection_(connection), request_(std::move(request)) {}

  [[nodiscard]] bool is_readable() const override { return taken_ < request_.size(); }
  [[nodiscard]] bool is_writable() const override { return connection_.is_there(); }
  ssize_t read(char* into, size_t size) override {
    const auto count = std::min(size, request_.size() - taken_);
    std::copy_n(request_.data() + taken_, count, into);
    taken_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* from, size_t size) override {
    return connection_.write({from, size}, kWriteWithin) ? static_cast<ssize_t>(size) : -1;
  }
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  [[nodiscard]] socket_t socket() const override { return connection_.socket(); }

 private:
  Connection& connection_;
  std::string request_;
  std::size_t taken_{};
};

/// The request that this thread answers.
thread_local const WebRequest* current = nullptr;

/// Every answer has these: the page loads from itself alone, is shown in no other, and is kept nowhere.
const httplib::Headers& usual_headers() {
  static const httplib::Headers headers{
      {"Content-Security-Policy",
       "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
       "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
      {"X-Content-Type-Options", "nosniff"},
      {"Referrer-Policy", "no-referrer"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Permissions-Policy", "camera=(), microphone=(), geolocation=()"},
      {"X-Frame-Options", "DENY"},
      {"Cache-Control", "no-store"}};
  return headers;
}

/// To a HEAD an answer has no body.
std::string refusal_text(int status, std::string_view why, bool with_body) {
  const auto answer = refusal(status, why);
  auto text = fmt::format("HTTP/1.1 {} {}\r\nConnection: close\r\nContent-Type: {}\r\nContent-Length: {}\r\n", status,
                          reason_of(status), answer.type, answer.body.size());
  if (status == 405) text += "Allow: GET, POST\r\n";
  for (const auto& [name, value] : usual_headers()) text += fmt::format("{}: {}\r\n", name, value);
  return text + "\r\n" + (with_body ? answer.body : "");
}

/// What is sent piece by piece ends when the server does, however slowly it is taken; in chunks where the client knows
/// them, and otherwise with the connection (RFC 9112, 6.1).
void put(const WebAnswer& answer, bool in_chunks, httplib::Response& response, const std::atomic<bool>& stopping) {
  response.status = answer.status;
  for (const auto& [name, value] : usual_headers()) {
    const bool other = std::ranges::any_of(answer.headers, [&](const auto& own) { return own.first == name; });
    if (!other) response.set_header(name, value);
  }
  for (const auto& [name, value] : answer.headers) response.set_header(name, value);
  if (!answer.stream) return response.set_content(answer.body, answer.type);
  const auto run = [stream = answer.stream, &stopping](httplib::DataSink& sink) {
    bool taken = true;
    const bool whole = stream([&](std::string_view piece) {
      taken = taken && !stopping && sink.write(piece.data(), piece.size());
      return taken;
    });
    return taken && whole;
  };
  if (answer.stream_size > 0)
    response.set_content_provider(answer.stream_size, answer.type,
                                  [run](size_t, size_t, httplib::DataSink& sink) { return run(sink); });
  else {
    const auto provide = [run](size_t, httplib::DataSink& sink) {
      const bool whole = run(sink);
      if (whole) sink.done();
      return whole;
    };
    in_chunks ? response.set_chunked_content_provider(answer.type, provide)
              : response.set_content_provider(answer.type, provide);
  }
}

}  // namespace

class WebServer::Guarded final : public httplib::Server {
 public:
  Guarded(const WebServerOptions& given, Answer answer) : options(given), answer_(std::move(answer)) {
    new_task_queue = [] { return new Threads; };
    set_socket_options([](socket_t socket) {
      const int on = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
      ::fcntl(socket, F_SETFD, FD_CLOEXEC);
    });
    set_keep_alive_max_count(kMostRequests);
    set_keep_alive_timeout(std::chrono::seconds(kIdle).count());
    set_pre_routing_handler([this](const httplib::Request&, httplib::Response& response) {
      put(answer_(*current), current->head.takes_chunks, response, stopping);
      return HandlerResponse::Handled;
    });
  }

  WebServerOptions options;
  std::atomic<bool> stopping{false}, served{false};

 private:
  bool process_and_close_socket(socket_t socket) override {
    Connection connection(Descriptor(socket), options.tls);
    if (shed || !connection.greet(kHeadWithin)) return false;
    std::string bytes;
    for (int i = 0; i < kMostRequests && !stopping && wait_for_request(connection, bytes, i == 0); ++i)
      if (!serve_one(connection, bytes)) break;
    connection.say_goodbye();
    return true;
  }

  /// Until bytes come. A connection that is idle makes room for those that wait.
  bool wait_for_request(const Connection& connection, const std::string& bytes, bool first) const {
    if (!bytes.empty()) return true;
    const Deadline deadline(first ? Duration(kHeadWithin) : Duration(kIdle));
    while (!deadline.over()) {
      if (connection.has_bytes(50ms)) return true;
      if (stopping || (Threads::is_full() && !first)) return false;
    }
    return false;
  }

  /// Reads one request and answers it; whether the connection goes on. `bytes` has what was read beyond.
  bool serve_one(Connection& connection, std::string& bytes) {
    const Deadline deadline{Duration(kHeadWithin)};
    std::optional<std::size_t> end;
    while (!(end = end_of_head(bytes)) && bytes.size() <= kLongestHead)
      if (!read_more(connection, bytes, deadline)) return bytes.empty() ? false : refuse(connection, {408, "too slow"});
    if (!end || *end > kLongestHead) return refuse(connection, {431, "the head is too long"});
    auto read = read_head(std::string_view(bytes).substr(0, *end));
    const bool wants_body = !bytes.starts_with("HEAD ");
    bytes.erase(0, *end);
    if (const auto* why = std::get_if<HeadRefusal>(&read)) return refuse(connection, *why, wants_body);
    WebRequest request{.head = std::move(std::get<RequestHead>(read)),
                       .body = {},
                       .peer = connection.peer(),
                       .secure = options.tls != nullptr};
    if (!is_host(request.head.header("host"))) return refuse(connection, {421, "this page has another name"});
    while (bytes.size() < request.head.body_size)
      if (!read_more(connection, bytes, deadline)) return refuse(connection, {408, "too slow"});
    request.body = bytes.substr(0, request.head.body_size);
    bytes.erase(0, request.head.body_size);
    if (options.behind_proxy) believe_proxy(request);
    return let_answer(connection, request);
  }

  static bool read_more(Connection& connection, std::string& bytes, const Deadline& deadline) {
    std::array<char, 4096> some{};
    const auto size = connection.read(some.data(), some.size(), deadline.left());
    bytes.append(some.data(), size);
    return size > 0;
  }

  static bool refuse(Connection& connection, const HeadRefusal& why, bool with_body = true) {
    if (connection.write(refusal_text(why.status, why.why, with_body), kWriteWithin)) drain(connection);
    return false;
  }

  /// Reads a little of what the client still sends, for the answer would be lost if the connection were reset.
  static void drain(Connection& connection) {
    connection.say_goodbye();
    const Deadline deadline(100ms);
    std::array<char, 4096> some{};
    for (int i = 0; i < 16 && connection.read(some.data(), some.size(), deadline.left()) > 0; ++i) {
    }
  }

  bool let_answer(Connection& connection, const WebRequest& request) {
    const bool close = !request.head.keep_alive;
    AnswerStream stream(connection, fmt::format("GET / HTTP/1.1\r\nHost: page\r\nConnection: {}\r\n\r\n",
                                                close ? "close" : "keep-alive"));
    current = &request;
    bool closed = false;
    const bool done = process_request(stream, close, closed, nullptr);
    current = nullptr;
    return done && !closed && !close;
  }

  [[nodiscard]] bool is_host(const std::string& host) const {
    return std::ranges::find(options.hosts, in_small_letters(host)) != options.hosts.end();
  }

  /// The proxy on this machine adds the address that it sees at the end.
  static void believe_proxy(WebRequest& request) {
    const auto chain = request.head.header("x-forwarded-for");
    const auto comma = chain.rfind(',');
    const auto last = trimmed(std::string_view(chain).substr(comma == std::string::npos ? 0 : comma + 1));
    if (!last.empty() && last.size() <= 45) request.peer = last;
    request.secure = request.head.header("x-forwarded-proto") == "https";
  }

  Answer answer_;
};

WebServer::WebServer(const WebServerOptions& options, Answer answer)
    : server_(std::make_unique<Guarded>(options, std::move(answer))) {}
WebServer::~WebServer() = default;

Result<int> WebServer::bind() {
  auto& options = server_->options;
  const bool any = options.port == 0;
  const int port = any ? server_->bind_to_any_port(options.address) : options.port;
  if (port <= 0 || (!any && !server_->bind_to_port(options.address, port)))
    return failure(FaultKind::usage, fmt::format("{}:{}", options.address, options.port),
                   "cannot be listened at: another program may be there, or the address is none of this machine's");
  options.port = port;
  std::vector<std::string> hosts;
  const bool v6 = options.address.find(':') != std::string::npos;
  auto names = options.hosts;
  names.push_back(v6 ? fmt::format("[{}]", options.address) : options.address);
  if (options.address == "127.0.0.1" || options.address == "::1") names.emplace_back("localhost");
  for (const auto& name : names) {
    hosts.push_back(in_small_letters(fmt::format("{}:{}", name, port)));
    if (options.behind_proxy || port == (options.tls ? 443 : 80)) hosts.push_back(in_small_letters(name));
  }
  options.hosts = std::move(hosts);
  return port;
}

void WebServer::serve() {
  server_->listen_after_bind();
  server_->served = true;
}

/// The library stops nothing before it runs, and a signal may come as early as that.
void WebServer::stop() {
  server_->stopping = true;
  while (!server_->is_running() && !server_->served) std::this_thread::sleep_for(1ms);
  server_->stop();
}

bool WebServer::is_stopping() const { return server_->stopping; }

}  // namespace gyrotherm::monitor
