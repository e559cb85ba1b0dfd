// SPDX-License-Identifier: Apache-2.0
/// An accepted connection, with or without TLS. Each wait has a limit: a slow peer delays only its own connection and
/// uses a limited share of a thread's time.
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
  /// Loads both files in PEM format. Fails with bad_file, also if the key does not belong to the certificate.
  [[nodiscard]] static Result<TlsServer> load(const std::string& certificate_file, const std::string& key_file);
  [[nodiscard]] ssl_ctx_st* context() const { return context_.get(); }

 private:
  struct Free {
    void operator()(ssl_ctx_st* context) const;
  };
  explicit TlsServer(ssl_ctx_st* context) : context_(context) {}
  std::unique_ptr<ssl_ctx_st, Free> context_;
};

/// A connection, used by one thread.
class Connection {
 public:
  /// Takes ownership of the socket and makes it non-blocking. `tls` may be null; it must outlive this.
  Connection(Descriptor socket, const TlsServer* tls);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Performs the TLS handshake if the connection uses TLS.
  [[nodiscard]] bool perform_handshake(Duration within);
  /// Waits for bytes and reads at most `most`. Returns 0 if the peer has closed, failed, or sent nothing in time.
  [[nodiscard]] std::size_t read(char* into, std::size_t most, Duration within);
  /// Sends all bytes. Returns false if the peer does not accept them in time.
  [[nodiscard]] bool write(std::string_view bytes, Duration within);
  /// Returns whether bytes or the end of the connection can be read.
  [[nodiscard]] bool has_bytes(Duration within) const;
  /// Returns whether the peer is still connected, as far as known without reading.
  [[nodiscard]] bool is_there() const;
  /// Closes the sending direction. Bytes from the peer can still be read.
  void shut_down_sending();
  [[nodiscard]] int socket() const { return socket_.number(); }
  /// Returns the peer's address: "127.0.0.1".
  [[nodiscard]] std::string peer() const;

 private:
  struct End {
    void operator()(ssl_st* tls) const;
  };
  Descriptor socket_;
  std::unique_ptr<ssl_st, End> tls_;
};

}  // namespace gyrotherm::monitor
