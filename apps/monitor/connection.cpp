// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/connection.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/program_start.hpp"

namespace gyrotherm::monitor {
namespace {

/// Returns the reason of the last error in words, such as "no start line".
std::string last_tls_error() {
  const char* reason = ERR_reason_error_string(ERR_get_error());
  ERR_clear_error();
  return reason != nullptr ? reason : "unknown error";
}

/// Returns the poll event for which a TLS call waits, or 0 if the call has failed.
short poll_event_for(int error) {
  if (error == SSL_ERROR_WANT_READ) return POLLIN;
  return error == SSL_ERROR_WANT_WRITE ? POLLOUT : short{0};
}

/// Repeats a TLS call until it succeeds. Returns its result, or 0 if it fails or the time is over.
template <class Call>
int repeat_call(ssl_st* tls, int socket, const Deadline& deadline, Call call) {
  for (;;) {
    ERR_clear_error();
    const int result = call();
    if (result > 0) return result;
    const auto event = poll_event_for(SSL_get_error(tls, result));
    if (event == 0 || !wait_until_ready(socket, event, deadline)) return 0;
  }
}

}  // namespace

void TlsServer::FreeContext::operator()(ssl_ctx_st* context) const { SSL_CTX_free(context); }

Result<TlsServer> TlsServer::load(const std::string& certificate_file, const std::string& key_file) {
  TlsServer server(SSL_CTX_new(TLS_server_method()));
  auto* context = server.context();
  if (context == nullptr) return failure(FaultKind::bad_file, certificate_file, last_tls_error());
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  SSL_CTX_set_mode(context,
                   SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER | SSL_MODE_RELEASE_BUFFERS);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  for (const auto& file : {certificate_file, key_file})
    if (const auto opened = open_regular_file(file); !opened) return failure(opened.error());
  if (SSL_CTX_use_certificate_chain_file(context, certificate_file.c_str()) != 1)
    return failure(FaultKind::bad_file, certificate_file, "is not a PEM certificate: " + last_tls_error());
  // A service cannot answer a prompt for a password.
  SSL_CTX_set_default_passwd_cb(context, [](char*, int, int, void*) { return -1; });
  const auto not_its_key = [&] {
    return failure(FaultKind::bad_file, key_file, "is not the key of the certificate " + certificate_file);
  };
  if (SSL_CTX_use_PrivateKey_file(context, key_file.c_str(), SSL_FILETYPE_PEM) != 1) {
    if (ERR_GET_REASON(ERR_peek_last_error()) == X509_R_KEY_VALUES_MISMATCH) return not_its_key();
    return failure(FaultKind::bad_file, key_file, "is not a PEM private key without a password: " + last_tls_error());
  }
  // A key of another kind replaces the certificate.
  const auto* certificate = SSL_CTX_get0_certificate(context);
  if (certificate == nullptr || SSL_CTX_check_private_key(context) != 1) return not_its_key();
  if (X509_cmp_current_time(X509_get0_notAfter(certificate)) < 0)
    write_to_stderr(fmt::format(
        "gyrotherm-monitor: warning: {}: the certificate has expired; browsers refuse the page\n", certificate_file));
  return server;
}

void Connection::FreeSession::operator()(ssl_st* tls) const {
  SSL_shutdown(tls);
  SSL_free(tls);
}

Connection::Connection(Descriptor socket, const TlsServer* tls) : socket_(std::move(socket)) {
  const int on = 1;
  ::fcntl(socket_.number(), F_SETFL, ::fcntl(socket_.number(), F_GETFL) | O_NONBLOCK);
  ::fcntl(socket_.number(), F_SETFD, FD_CLOEXEC);
  ::setsockopt(socket_.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  // Limits the data that wait for a slow client. The kernel doubles the value.
  constexpr int kSendBufferBytes = 128 * 1024;
  ::setsockopt(socket_.number(), SOL_SOCKET, SO_SNDBUF, &kSendBufferBytes, sizeof kSendBufferBytes);
  if (tls == nullptr) return;
  tls_.reset(SSL_new(tls->context()));
  if (tls_) SSL_set_fd(tls_.get(), socket_.number());
}

Connection::~Connection() = default;

bool Connection::perform_handshake(Duration timeout) {
  if (!tls_) return true;
  return repeat_call(tls_.get(), socket(), Deadline(timeout), [&] { return SSL_accept(tls_.get()); }) > 0;
}

std::size_t Connection::read(char* into, std::size_t max_bytes, Duration timeout) {
  const Deadline deadline(timeout);
  if (tls_) {
    const auto size = static_cast<int>(std::min<std::size_t>(max_bytes, 16384));
    return static_cast<std::size_t>(
        repeat_call(tls_.get(), socket(), deadline, [&] { return SSL_read(tls_.get(), into, size); }));
  }
  while (wait_until_ready(socket(), POLLIN, deadline)) {
    const auto size = ::recv(socket(), into, max_bytes, 0);
    if (size >= 0) return static_cast<std::size_t>(size);
    if (!would_block()) return 0;
  }
  return 0;
}

bool Connection::write(std::string_view bytes, Duration timeout) {
  const Deadline deadline(timeout);
  while (!bytes.empty()) {
    if (tls_) {
      const auto size = static_cast<int>(std::min<std::size_t>(bytes.size(), 16384));
      const int sent =
          repeat_call(tls_.get(), socket(), deadline, [&] { return SSL_write(tls_.get(), bytes.data(), size); });
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
      continue;
    }
    const auto sent = ::send(socket(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0)
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    else if (sent == 0 || !would_block() || !wait_until_ready(socket(), POLLOUT, deadline))
      return false;
    if (deadline.has_passed() && !bytes.empty()) return false;
  }
  return true;
}

void Connection::shut_down_sending() {
  if (tls_) {
    ERR_clear_error();
    SSL_shutdown(tls_.get());
  }
  ::shutdown(socket(), SHUT_WR);
}

bool Connection::wait_until_readable(Duration timeout) const {
  if (tls_ && SSL_pending(tls_.get()) > 0) return true;
  return wait_until_ready(socket(), POLLIN, Deadline(timeout));
}

bool Connection::is_connected() const {
  pollfd line{socket(), POLLRDHUP, 0};
  return ::poll(&line, 1, 0) >= 0 && (line.revents & (POLLERR | POLLHUP | POLLRDHUP | POLLNVAL)) == 0;
}

std::string Connection::peer() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getpeername(socket(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.ss_family == AF_INET)
    ::inet_ntop(AF_INET, &reinterpret_cast<sockaddr_in&>(address).sin_addr, text.data(), text.size());
  else if (address.ss_family == AF_INET6)
    ::inet_ntop(AF_INET6, &reinterpret_cast<sockaddr_in6&>(address).sin6_addr, text.data(), text.size());
  return text.data();
}

}  // namespace gyrotherm::monitor
