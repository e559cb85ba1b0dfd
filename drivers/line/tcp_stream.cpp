#include "drivers/line/tcp_stream.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/line/backoff.hpp"
#include "drivers/line/descriptor.hpp"

namespace gyrotherm {
namespace {

class TcpStream final : public ByteStream {
 public:
  TcpStream(TcpLine line, Duration connect_within) : line_(std::move(line)), connect_within_(connect_within) {}

  Result<std::size_t> read(std::span<std::byte> buffer, Duration within) override;
  Result<void> write(std::span<const std::byte> bytes, Duration within) override;

 private:
  [[nodiscard]] Result<void> connect();
  [[nodiscard]] Result<void> open_socket();
  void close_line();  ///< to be opened again at the next use
  [[nodiscard]] std::string place() const { return fmt::format("tcp {}:{}", line_.host, line_.port); }
  [[nodiscard]] tl::unexpected<Fault> broken(const char* why);

  TcpLine line_;
  Duration connect_within_;
  Descriptor socket_;
  Backoff backoff_;
};

void TcpStream::close_line() {
  socket_.close();
  backoff_.failed();
}

tl::unexpected<Fault> TcpStream::broken(const char* why) {
  close_line();
  return failure(FaultKind::disconnected, place(), why);
}

Result<void> TcpStream::open_socket() {
  sockaddr_in peer{};
  peer.sin_family = AF_INET;
  peer.sin_port = htons(line_.port);
  if (inet_pton(AF_INET, line_.host.c_str(), &peer.sin_addr) != 1)
    return broken("the host is not a numeric IPv4 address");

  socket_ = Descriptor(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket_.is_open()) return broken(std::strerror(errno));
  guard_against_half_open(socket_.number());
  if (::connect(socket_.number(), reinterpret_cast<const sockaddr*>(&peer), sizeof peer) == 0) return {};
  if (errno != EINPROGRESS) return broken(std::strerror(errno));
  if (!ready(socket_.number(), POLLOUT, Deadline(connect_within_))) return broken("no connection in time");
  int error = 0;
  socklen_t size = sizeof error;
  getsockopt(socket_.number(), SOL_SOCKET, SO_ERROR, &error, &size);
  if (error != 0) return broken(std::strerror(error));
  return {};
}

Result<void> TcpStream::connect() {
  if (socket_.is_open()) return {};
  if (backoff_.left() > Duration::zero()) return failure(FaultKind::disconnected, place(), backoff_.words());
  return open_socket();
}

Result<std::size_t> TcpStream::read(std::span<std::byte> buffer, Duration within) {
  if (auto connected = connect(); !connected) return failure(std::move(connected.error()));
  const Deadline deadline(within);
  while (true) {
    const auto size = recv(socket_.number(), buffer.data(), buffer.size(), 0);
    if (size > 0) {
      backoff_.succeeded();
      return static_cast<std::size_t>(size);
    }
    if (size == 0) return broken("the other end closed the line");
    if (!would_block()) return broken(std::strerror(errno));
    if (deadline.over() || !ready(socket_.number(), POLLIN, deadline))
      return failure(FaultKind::timeout, place(), fmt::format("nothing came in {:.3f} s", to_seconds(within)));
  }
}

Result<void> TcpStream::write(std::span<const std::byte> bytes, Duration within) {
  if (auto connected = connect(); !connected) return connected;
  const Deadline deadline(within);
  while (!bytes.empty()) {
    const auto size = send(socket_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (size > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(size));
      continue;
    }
    if (!would_block()) return broken(std::strerror(errno));
    if (!deadline.over() && ready(socket_.number(), POLLOUT, deadline)) continue;
    close_line();  // a part may have been sent
    return failure(FaultKind::timeout, place(), fmt::format("could not send in {:.3f} s", to_seconds(within)));
  }
  return {};
}

}  // namespace

std::unique_ptr<ByteStream> make_tcp_stream(const TcpLine& line, Duration connect_within) {
  return std::make_unique<TcpStream>(line, connect_within);
}

}  // namespace gyrotherm
