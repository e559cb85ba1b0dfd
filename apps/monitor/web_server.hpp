// SPDX-License-Identifier: Apache-2.0
/// The server of the page: accepts connections, reads requests (http_message.hpp) within limits of size and time, and
/// sends answers.
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
  /// Null: no TLS.
  const TlsServer* tls{};
  /// Requests come only from a proxy on this machine. It provides TLS and sends the client's address and protocol in
  /// X-Forwarded-For and X-Forwarded-Proto.
  bool behind_proxy{};
};

/// The server. It has 32 threads, each for one connection at a time. All of them call `answer`.
class WebServer {
 public:
  using Answer = std::function<WebAnswer(const WebRequest&)>;

  WebServer(const WebServerOptions& options, Answer answer);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Binds the address. Returns the port. Fails with usage if the address is not available, for example used by another
  /// program.
  [[nodiscard]] Result<int> bind();
  /// Serves until stop(), which any thread may call, even before serve().
  void serve();
  /// Ends serve(). If serve() has not been called yet, that call returns immediately.
  void stop();
  [[nodiscard]] bool is_stopping() const;

 private:
  class Listeners;
  std::unique_ptr<Listeners> listeners_;
};

}  // namespace gyrotherm::monitor
