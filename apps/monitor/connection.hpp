// SPDX-License-Identifier: Apache-2.0
/// An accepted connection, with TLS or without: every wait has an end, so that whoever reads or writes slowly costs his
/// own connection and no more of a thread's time than was set.
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

/// A certificate and its key, as a server shows them: TLS 1.2 and later. Any thread.
class TlsServer {
 public:
  /// Both files are PEM. Fails with bad_file, also if the key is not the certificate's.
  [[nodiscard]] static Result<TlsServer> load(const std::string& certificate_file, const std::string& key_file);
  [[nodiscard]] ssl_ctx_st* context() const { return context_.get(); }

 private:
  struct Free {
    void operator()(ssl_ctx_st* context) const;
  };
  explicit TlsServer(ssl_ctx_st* context) : context_(context) {}
  std::unique_ptr<ssl_ctx_st, Free> context_;
};

/// One thread.
class Connection {
 public:
  /// Takes the socket over and makes it non-blocking; `tls` may be null, and outlives this.
  Connection(Descriptor socket, const TlsServer* tls);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Shakes hands, where there is TLS.
  [[nodiscard]] bool greet(Duration within);
  /// Waits for bytes and reads what there is, at most `most`; 0: the other end has closed, failed, or said nothing in
  /// time.
  [[nodiscard]] std::size_t read(char* into, std::size_t most, Duration within);
  /// Sends all of it; false if the other end does not take it in time.
  [[nodiscard]] bool write(std::string_view bytes, Duration within);
  /// Whether bytes, or the end, wait to be read.
  [[nodiscard]] bool has_bytes(Duration within) const;
  /// Whether the other end is still there, as far as can be told without reading.
  [[nodiscard]] bool is_there() const;
  /// Tells the other end that nothing more comes; what it still sends can be read.
  void say_goodbye();
  [[nodiscard]] int socket() const { return socket_.number(); }
  [[nodiscard]] std::string peer() const;  ///< the address: "127.0.0.1"

 private:
  struct End {
    void operator()(ssl_st* tls) const;
  };
  Descriptor socket_;
  std::unique_ptr<ssl_st, End> tls_;
};

}  // namespace gyrotherm::monitor
