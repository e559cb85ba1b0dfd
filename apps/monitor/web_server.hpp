// SPDX-License-Identifier: Apache-2.0
/// The server of the page: accepts connections, reads requests (http_message.hpp) within bounds of size and time, and
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
  int port{};                        ///< 0: any that is free
  std::vector<std::string> hosts{};  ///< names by which the page may be called, beside the address itself
  const TlsServer* tls{};            ///< null: without TLS
  /// Requests come from a proxy on this machine alone, which speaks TLS to the others and says in X-Forwarded-For and
  /// X-Forwarded-Proto who they are.
  bool behind_proxy{};
};

/// Threads: 32, each for one connection at a time; `answer` is called by all of them.
class WebServer {
 public:
  using Answer = std::function<WebAnswer(const WebRequest&)>;

  WebServer(const WebServerOptions& options, Answer answer);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Binds; the port. Fails with usage if the address cannot be had: another program may have it.
  [[nodiscard]] Result<int> bind();
  /// Serves until stop(), which any thread may call, also before this has begun.
  void serve();
  /// Ends serve(), or lets it return at once when it is called.
  void stop();
  [[nodiscard]] bool is_stopping() const;

 private:
  class Lines;
  std::unique_ptr<Lines> lines_;
};

}  // namespace gyrotherm::monitor
