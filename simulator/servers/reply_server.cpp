// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/reply_server.hpp"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <utility>

namespace gyrotherm::simulator {
namespace {

constexpr std::size_t kMostBytesAtOnce = 4096;
constexpr int kMostEvents = 64;

}  // namespace

ReplyServer::ReplyServer(std::mutex& laboratory_guard)
    : laboratory_guard_(laboratory_guard),
      poll_(::epoll_create1(EPOLL_CLOEXEC)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      incoming_(kMostBytesAtOnce) {
  watch(stop_.number());
}

ReplyServer::~ReplyServer() {
  ::eventfd_write(stop_.number(), 1);
  if (thread_.joinable()) thread_.join();
}

void ReplyServer::add(Descriptor listener, MakeSession make_session) {
  const int descriptor = listener.number();
  watch(descriptor);
  listeners_.emplace(descriptor, Listener{std::move(listener), std::move(make_session)});
}

void ReplyServer::add(Pty line, MakeSession make_session) {
  const int descriptor = line.ours.number();
  watch(descriptor);
  lines_.emplace(descriptor, Line{std::move(line), std::move(make_session), nullptr});
}

void ReplyServer::start() {
  thread_ = std::thread([this] { run(); });
}

void ReplyServer::watch(int descriptor) {
  epoll_event interest{};
  interest.events = EPOLLIN;
  interest.data.fd = descriptor;
  ::epoll_ctl(poll_.number(), EPOLL_CTL_ADD, descriptor, &interest);
}

void ReplyServer::run() {
  while (serve_once()) {
  }
}

bool ReplyServer::serve_once() {
  std::array<epoll_event, kMostEvents> events{};
  const int count = ::epoll_wait(poll_.number(), events.data(), kMostEvents, -1);
  if (count < 0) return errno == EINTR;
  for (int i = 0; i < count; ++i) {
    const int descriptor = events[static_cast<std::size_t>(i)].data.fd;
    if (descriptor == stop_.number()) return false;
    const auto listener = listeners_.find(descriptor);
    if (listener == listeners_.end())
      serve(descriptor);
    else
      admit(listener->second);
  }
  return true;
}

void ReplyServer::admit(Listener& listener) {
  auto socket = accept_client(listener.socket);
  if (!socket.is_open() || listener.clients == kMaxClients) return;
  const int descriptor = socket.number();
  const std::scoped_lock lock(laboratory_guard_);
  clients_.emplace(descriptor, Client{std::move(socket), listener.make_session(), listener});
  ++listener.clients;
  watch(descriptor);
}

void ReplyServer::serve(int descriptor) {
  if (const auto line = lines_.find(descriptor); line != lines_.end()) return exchange(line->second);
  const auto found = clients_.find(descriptor);
  if (found == clients_.end() || exchange(found->second)) return;
  --found->second.listener.clients;
  clients_.erase(found);
}

/// Receives and answers. Returns false if the client must be dropped.
bool ReplyServer::exchange(Client& client) {
  const auto size = ::recv(client.socket.number(), incoming_.data(), incoming_.size(), MSG_DONTWAIT);
  if (size < 0) return errno == EAGAIN || errno == EINTR;
  if (size == 0) return false;
  reply_.clear();
  {
    const std::scoped_lock lock(laboratory_guard_);
    if (!client.session->feed(std::span(incoming_).first(static_cast<std::size_t>(size)), reply_)) return false;
  }
  return reply_.empty() || send_now(client.socket, reply_);
}

/// Receives and answers. Bytes that violate the protocol end the session; the next bytes begin another.
void ReplyServer::exchange(Line& line) {
  const auto size = ::read(line.pty.ours.number(), incoming_.data(), incoming_.size());
  if (size <= 0) return;
  reply_.clear();
  {
    const std::scoped_lock lock(laboratory_guard_);
    if (!line.session) line.session = line.make_session();
    if (!line.session->feed(std::span(incoming_).first(static_cast<std::size_t>(size)), reply_)) line.session.reset();
  }
  if (!reply_.empty()) send_now(line.pty, reply_);
}

}  // namespace gyrotherm::simulator
