// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/secop_server.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <vector>

#include "core/deadline.hpp"

namespace gyrotherm::monitor {
namespace {

using std::chrono_literals::operator""s;
using std::chrono_literals::operator""ms;

constexpr auto kLookEvery = 200ms;
constexpr int kWaitMs = 50;
constexpr std::size_t kMostAtRest = 64 * 1024;    ///< bytes that wait to be sent, before no more is asked for
constexpr std::size_t kMostWaiting = 512 * 1024;  ///< … before the client is given up
constexpr auto kIdle = 60s;      ///< without a question, and without being told anything: it makes room for another
constexpr auto kPatience = 10s;  ///< with a client that takes nothing of what waits for it
constexpr double kRequests = 200, kRequestsPerSecond = 100, kNewcomers = 32, kNewcomersPerSecond = 20;

/// The address of a socket, and how long it is; 0: the text is no numeric address.
socklen_t address_of(const std::string& text, int port, sockaddr_storage& address) {
  auto& v4 = reinterpret_cast<sockaddr_in&>(address);
  auto& v6 = reinterpret_cast<sockaddr_in6&>(address);
  const auto number = htons(static_cast<std::uint16_t>(port));
  if (::inet_pton(AF_INET, text.c_str(), &v4.sin_addr) == 1) {
    v4.sin_family = AF_INET;
    v4.sin_port = number;
    return sizeof v4;
  }
  if (::inet_pton(AF_INET6, text.c_str(), &v6.sin6_addr) == 1) {
    v6.sin6_family = AF_INET6;
    v6.sin6_port = number;
    return sizeof v6;
  }
  return 0;
}

int port_of(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(address).sin6_port
                                             : reinterpret_cast<sockaddr_in&>(address).sin_port);
}

}  // namespace

bool Allowance::has_one(Duration now) {
  left_ = std::min(most_, left_ + to_seconds(now - at_) * per_s_);
  at_ = now;
  return left_ >= 1;
}

SecopServer::SecopServer(SecopRun& run, std::function<bool()> may_look, const Clock& clock)
    : run_(run),
      may_look_(std::move(may_look)),
      clock_(clock),
      newcomers_(kNewcomers, kNewcomersPerSecond, clock.now().since_start) {}

Result<int> SecopServer::bind(const std::string& address, int port) {
  const auto place = fmt::format("--secop {}:{}", address, port);
  sockaddr_storage where{};
  const auto size = address_of(address, port, where);
  if (size == 0) return failure(FaultKind::usage, place, "is no numeric address, as 127.0.0.1:10767");
  Descriptor socket(::socket(where.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int on = 1;
  ::setsockopt(socket.number(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  constexpr int kBacklog = 16;
  if (!socket.is_open() || ::bind(socket.number(), reinterpret_cast<sockaddr*>(&where), size) != 0 ||
      ::listen(socket.number(), kBacklog) != 0)
    return failure(FaultKind::usage, place, fmt::format("cannot be listened at: {}", std::strerror(errno)));
  listener_ = std::move(socket);
  return port_of(listener_.number());
}

void SecopServer::serve() {
  run_.look();
  while (!stopped_) {
    wait();
    const auto now = clock_.now().since_start;
    if (!may_look_()) clients_.clear();
    if (!clients_.empty() && now - looked_ >= Duration(kLookEvery)) {
      looked_ = now;
      tell();
    }
    for (auto& client : clients_) {
      answer(client, now);
      write(client, now);
    }
    std::erase_if(clients_, [&](const Client& client) {
      const bool answered = client.out.empty() && client.in.find('\n') == std::string::npos;
      return !client.socket.is_open() || (client.over && answered) || client.out.size() > kMostWaiting ||
             now - client.sent > Duration(kPatience);
    });
  }
}

/// Until somebody comes, asks or reads, at most for a moment; then takes what has come.
void SecopServer::wait() {
  const auto now = clock_.now().since_start;
  std::vector<pollfd> lines;
  const short newcomers = newcomers_.has_one(now) ? POLLIN : short{0};
  lines.push_back({listener_.number(), newcomers, 0});
  for (auto& client : clients_) {
    const bool may_ask = !client.over && client.out.size() < kMostAtRest && client.requests.has_one(now);
    lines.push_back(
        {client.socket.number(), static_cast<short>((may_ask ? POLLIN : 0) | (client.out.empty() ? 0 : POLLOUT)), 0});
  }
  ::poll(lines.data(), lines.size(), kWaitMs);
  std::size_t i = 1;
  for (auto& client : clients_) {
    const auto came = lines[i++].revents;
    if ((came & POLLIN) != 0)
      read(client);
    else if ((came & (POLLERR | POLLHUP | POLLNVAL)) != 0)
      client.socket.close();
  }
  if ((lines.front().revents & POLLIN) != 0) accept(now);
}

void SecopServer::accept(Duration now) {
  newcomers_.take();
  Descriptor socket(::accept4(listener_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket.is_open() || !may_look_()) return;
  if (clients_.size() >= kMostSecopClients) make_room(now);
  if (clients_.size() >= kMostSecopClients) return;
  const int on = 1;
  constexpr int kSendBuffer = 64 * 1024;
  ::setsockopt(socket.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  ::setsockopt(socket.number(), SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
  clients_.push_back({.socket = std::move(socket),
                      .requests = Allowance(kRequests, kRequestsPerSecond, now),
                      .heard = now,
                      .sent = now});
}

void SecopServer::make_room(Duration now) {
  const auto idle = std::ranges::min_element(
      clients_, {}, [](const Client& client) { return std::pair(client.session.is_active(), client.heard); });
  if (!idle->session.is_active() && now - idle->heard >= Duration(kIdle)) clients_.erase(idle);
}

/// One piece; what is not read waits at the other end.
void SecopServer::read(Client& client) {
  std::array<char, 4096> some{};
  const auto size = ::recv(client.socket.number(), some.data(), some.size(), 0);
  if (size > 0)
    client.in.append(some.data(), static_cast<std::size_t>(size));
  else if (size == 0)
    client.over = true;
  else if (!would_block())
    client.socket.close();
}

/// As many lines as there are, and as it may ask. A longer one than is allowed ends the connection.
void SecopServer::answer(Client& client, Duration now) {
  std::size_t begin = 0;
  while (client.out.size() < kMostAtRest && client.requests.has_one(now)) {
    const auto end = client.in.find('\n', begin);
    const auto size = (end == std::string::npos ? client.in.size() : end) - begin;
    if (size > kLongestSecopLine + 1) {
      client.out += refuse_long_secop_line();
      client.over = true;
      begin = client.in.size();
      break;
    }
    if (end == std::string::npos) break;
    auto line = std::string_view(client.in).substr(begin, size);
    if (line.ends_with('\r')) line.remove_suffix(1);
    client.requests.take();
    client.heard = now;
    client.knows = true;
    client.out += answer_secop(run_.state(), client.session, line, to_seconds(clock_.now().utc));
    begin = end + 1;
  }
  client.in.erase(0, begin);
}

void SecopServer::write(Client& client, Duration now) {
  if (client.out.empty()) client.sent = now;
  while (!client.out.empty() && client.socket.is_open()) {
    const auto sent = ::send(client.socket.number(), client.out.data(), client.out.size(), MSG_NOSIGNAL);
    if (sent <= 0) {
      if (!would_block()) client.socket.close();
      return;
    }
    client.out.erase(0, static_cast<std::size_t>(sent));
    client.sent = now;
  }
}

/// Where the structure is another one the clients are to come back and ask for it: the protocol has no word for that.
void SecopServer::tell() {
  const auto before = run_.state().node;
  if (run_.look()) return void(std::erase_if(clients_, [](const Client& client) { return client.knows; }));
  for (auto& client : clients_)
    if (client.session.is_active()) client.out += secop_news(before, run_.state().node, client.session);
}

}  // namespace gyrotherm::monitor
