// SPDX-License-Identifier: Apache-2.0
#include "sequencer/watchdog/guard_post.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <utility>

#include "core/abstract_socket.hpp"
#include "core/clock.hpp"
#include "core/deadline.hpp"
#include "core/process.hpp"
#include "core/text.hpp"
#include "drivers/chamber/chamber_lock.hpp"

namespace gyrotherm::watchdog {
namespace {

constexpr std::string_view kPrefix = "gyrotherm-guard/";
/// Separates the chamber from the process in the name of a post.
constexpr char kProcessMark = '#';
constexpr std::string_view kTakenOver = "taken over ";
constexpr int kMaxReports = 64;  ///< length of the queue of a post
constexpr auto kReportTimeout = std::chrono::milliseconds(200);

/// Returns the part of the name that all posts of one chamber share. A name holds 107 bytes at most (unix(7)), so a
/// long place is replaced by its hash and its end.
std::string shared_name(const std::string& place) {
  constexpr std::size_t kMaxPlainLength = 40;
  return fmt::format("{}{}{}", kPrefix, shorten_for_name(place, kMaxPlainLength), kProcessMark);
}

/// Returns the names of the posts that begin with `prefix`, each once.
std::vector<std::string> find_post_names(const std::string& prefix) {
  std::ifstream sockets("/proc/net/unix");
  std::vector<std::string> names;
  for (std::string line; std::getline(sockets, line);) {
    const auto at = line.find("@" + prefix);
    if (at == std::string::npos) continue;
    auto name = line.substr(at + 1);
    if (std::ranges::count(names, name) == 0) names.push_back(std::move(name));
  }
  return names;
}

/// Returns the last argument of a guard's command line, which is its record.
std::string read_guarded_record(std::int64_t pid) {
  std::ifstream file(fmt::format("/proc/{}/cmdline", pid));
  std::string record;
  for (std::string argument; std::getline(file, argument, '\0');) record = argument;
  return record;
}

/// Connects to a post. Returns a closed descriptor if the post is gone or its queue is full.
Descriptor connect_to_post(const std::string& name) {
  const auto address = make_abstract_address(name);
  auto socket = open_stream_socket();
  if (!socket.is_open() || ::connect(socket.number(), address.pointer(), address.size) != 0) return {};
  return socket;
}

/// Reads the report of a connection. Returns the record of the run, or nothing if there is no report.
std::optional<std::string> read_report(const Descriptor& caller) {
  const Deadline deadline(kReportTimeout);
  std::string report;
  for (std::array<char, 4096> bytes{}; !report.ends_with('\n') && report.size() <= 2 * bytes.size();) {
    if (!wait_until_ready(caller.number(), POLLIN, deadline)) return {};
    const auto size = ::recv(caller.number(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size <= 0) return {};
    report.append(bytes.data(), static_cast<std::size_t>(size));
  }
  if (!report.starts_with(kTakenOver)) return {};
  return plain(report.substr(kTakenOver.size(), report.size() - kTakenOver.size() - 1));
}

}  // namespace

GuardPost::GuardPost(const std::string& place, std::int64_t watched_pid) : watched_pid_(watched_pid) {
  auto socket = open_stream_socket();
  const auto address =
      make_abstract_address(fmt::format("{}{}-{:x}", shared_name(place), ::getpid(), since_boot().count()));
  if (socket.is_open() && ::bind(socket.number(), address.pointer(), address.size) == 0 &&
      ::listen(socket.number(), kMaxReports) == 0)
    socket_ = std::move(socket);
}

std::optional<std::string> GuardPost::find_successor() {
  for (int i = 0; i < kMaxReports && socket_.is_open() && !successor_; ++i) {
    const Descriptor caller(::accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!caller.is_open()) break;
    const auto peer = read_peer(caller.number());
    if (!peer || peer->pid == watched_pid_ || !drivers::may_drive_chambers(peer->uid)) continue;
    if (const auto record = read_report(caller))
      successor_ = fmt::format("process {} of {}, record {}", peer->pid, describe_user(peer->uid), *record);
  }
  return successor_;
}

std::vector<WaitingGuard> find_waiting_guards(const std::string& place) {
  std::vector<WaitingGuard> guards;
  for (const auto& name : find_post_names(place.empty() ? std::string(kPrefix) : shared_name(place))) {
    const auto peer = read_peer(connect_to_post(name).number());
    if (!peer || !drivers::may_drive_chambers(peer->uid)) continue;
    const auto record = read_guarded_record(peer->pid);
    guards.push_back({.name = name,
                      .pid = peer->pid,
                      .uid = peer->uid,
                      .record = record,
                      .words = fmt::format("process {} of {}, which guards the chamber for {}", peer->pid,
                                           describe_user(peer->uid), record.empty() ? "a dead run" : record)});
  }
  return guards;
}

void relieve_guards(const std::string& place, const std::string& record) {
  const auto report = fmt::format("{}{}\n", kTakenOver, record);
  for (const auto& name : find_post_names(shared_name(place)))
    if (const auto post = connect_to_post(name); post.is_open()) [[maybe_unused]]
      const auto sent = ::send(post.number(), report.data(), report.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace gyrotherm::watchdog
