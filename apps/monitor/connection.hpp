// SPDX-License-Identifier: Apache-2.0
/// An accepted connection, with or without TLS. Each wait has a time limit, so a slow peer delays only its own
/// connection and occupies a thread for a limited time.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "core/file.hpp"
#include "core/quantity.hpp"
#include "core/result.hpp"

struct ssl_ctx_st;
struct ssl_st;

namespace gyrotherm::monitor {

/// A server certificate and its key, for TLS 1.2 and later. Usable from any thread.
class TlsServer {
 public:
  /// Loads both files, in PEM format. Fails with bad_file if one is invalid or the key does not match the certificate.
  [[nodiscard]] static Result<TlsServer> load(const std::string& certificate_file, const std::string& key_file);
  [[nodiscard]] ssl_ctx_st* context() const { return context_.get(); }

 private:
  struct FreeContext {
    void operator()(ssl_ctx_st* context) const;
  };
  explicit TlsServer(ssl_ctx_st* context) : context_(context) {}
  std::unique_ptr<ssl_ctx_st, FreeContext> context_;
};

/// A connection. Used by one thread.
class Connection {
 public:
  /// Takes ownership of the socket and makes it non-blocking. `tls` is null for a connection without TLS; it must
  /// outlive the connection.
  Connection(Descriptor socket, const TlsServer* tls);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Performs the TLS handshake. Returns true immediately without TLS, and false if the handshake fails or takes too
  /// long.
  [[nodiscard]] bool perform_handshake(Duration timeout);
  /// Waits for bytes and reads at most `max_bytes`. Returns their number, or 0 if the connection is closed or has
  /// failed, or if no byte arrives in time.
  [[nodiscard]] std::size_t read(char* into, std::size_t max_bytes, Duration timeout);
  /// Sends all bytes. Returns false if the peer does not accept them in time.
  [[nodiscard]] bool write(std::string_view bytes, Duration timeout);
  /// Waits until bytes or the end of the connection can be read. Returns false if neither arrives in time.
  [[nodiscard]] bool wait_until_readable(Duration timeout) const;
  /// Returns whether the peer is still connected. Does not read.
  [[nodiscard]] bool is_connected() const;
  /// Closes the sending direction. Bytes from the peer can still be read.
  void shut_down_sending();
  [[nodiscard]] int socket() const { return socket_.number(); }
  /// Returns the peer's address, such as "127.0.0.1".
  [[nodiscard]] std::string peer() const;

 private:
  struct FreeSession {
    void operator()(ssl_st* tls) const;
  };
  Descriptor socket_;
  std::unique_ptr<ssl_st, FreeSession> tls_;
};

}  // namespace gyrotherm::monitor
