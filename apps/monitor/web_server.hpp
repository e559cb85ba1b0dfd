// SPDX-License-Identifier: Apache-2.0
/// The HTTP server: accepts connections, reads requests (http_message.hpp) within limits of size and time, and sends
/// answers.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/monitor/connection.hpp"
#include "apps/monitor/web.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

struct WebServerOptions {
  std::string address = "127.0.0.1";
  /// 0 selects a free port.
  int port{};
  /// Host names of the page in addition to the address.
  std::vector<std::string> hosts{};
  /// Null: the server does not use TLS.
  const TlsServer* tls{};
  /// All requests come from a proxy on this machine. The proxy terminates TLS and sends the client's address and
  /// protocol in X-Forwarded-For and X-Forwarded-Proto.
  bool behind_proxy{};
};

/// The server. Each of its 32 threads serves one connection at a time, and calls `answer`.
class WebServer {
 public:
  using Answer = std::function<WebAnswer(const WebRequest&)>;

  WebServer(const WebServerOptions& options, Answer answer);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Binds the address. Returns the port. Fails with storage if the address is not available, for example because
  /// another program uses it.
  [[nodiscard]] Result<int> bind();
  /// Serves until a thread calls stop(). Returns immediately if stop() was called before.
  void serve();
  /// Ends serve().
  void stop();
  [[nodiscard]] bool is_stopping() const;

 private:
  class ServerThreads;
  std::unique_ptr<ServerThreads> server_threads_;
};

}  // namespace gyrotherm::monitor
