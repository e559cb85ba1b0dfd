// SPDX-License-Identifier: Apache-2.0
#include "sequencer/control/control_socket.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include "core/abstract_socket.hpp"
#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/json_reader.hpp"
#include "core/process.hpp"

namespace gyrotherm::control {
namespace {

constexpr std::size_t kMaxClients = 8;
constexpr int kMaxNewClients = 64;  ///< accepted in one call
constexpr mode_t kOwnerAndGroup = 0660, kOwner = 0600;
constexpr Duration kNamingTimeout = std::chrono::seconds(1), kRetryEvery = std::chrono::milliseconds(50);
constexpr const char* kStatusEnding = ".status";  ///< "RUN.db.status" names the writer of RUN.db

/// Address of a socket in a folder. The address refers to the open folder, so the folder's path may have any length.
struct Address {
  Descriptor folder;
  sockaddr_un text{};
};

Result<Address> make_address(const std::string& path) {
  const auto split = std::filesystem::path(path);
  const auto parent = split.parent_path().empty() ? std::string(".") : split.parent_path().string();
  Address address{.folder = Descriptor(::open(parent.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC))};
  if (!address.folder.is_open()) return failure(FaultKind::usage, parent, std::strerror(errno));
  const auto name = fmt::format("/proc/self/fd/{}/{}", address.folder.number(), split.filename().string());
  if (name.size() >= sizeof address.text.sun_path)
    return failure(FaultKind::usage, path, "the name is too long for a socket");
  address.text.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.text.sun_path);
  return address;
}

const sockaddr* as_sockaddr(const Address& address) { return reinterpret_cast<const sockaddr*>(&address.text); }

Descriptor make_socket(int more_flags) {
  return Descriptor(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | more_flags, 0));
}

Descriptor spare_descriptor() { return Descriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

std::string client_user(int client, const std::string& for_user) {
  const auto peer = read_peer(client);
  if (for_user.empty()) return peer ? describe_user(peer->uid) : "unknown";
  if (!peer) return fmt::format("{} (through an unknown user)", for_user);
  return fmt::format("{} (through {}, uid {})", for_user, user_name(peer->uid), peer->uid);
}

/// Sets the mode of the socket at that path. Fails if the path is a link, or not a socket of this user. Excludes the
/// group if the umask does, like replace_own_file().
bool open_to_owner_and_group(const Address& address, const std::string& name) {
  const Descriptor made(::openat(address.folder.number(), name.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC));
  struct stat found {};
  if (!made.is_open() || ::fstat(made.number(), &found) != 0) return false;
  if (!S_ISSOCK(found.st_mode) || found.st_uid != ::geteuid()) return false;
  const mode_t mode = (found.st_mode & S_IRGRP) != 0 ? kOwnerAndGroup : kOwner;
  return ::chmod(fmt::format("/proc/self/fd/{}", made.number()).c_str(), mode) == 0;
}

ControlAnswer answer_message(std::string_view message, int client, const Listener& listener) {
  const auto request = parse_request(message);
  return request ? listener(*request, client_user(client, request->for_user))
                 : ControlAnswer{.done = false, .text = request.error().what};
}

/// Answers one client. Returns false once the client is done.
bool serve_client(int client, const Listener& listener) {
  std::array<char, kLongestRequest + 1> message{};
  const auto size = ::recv(client, message.data(), message.size(), MSG_DONTWAIT);
  if (size < 0 && would_block()) return true;
  if (size <= 0) return false;
  const auto answer = to_message(answer_message({message.data(), static_cast<std::size_t>(size)}, client, listener));
  ::send(client, answer.data(), answer.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  return false;
}

}  // namespace

std::string control_socket_path(const std::string& record) { return record + ".socket"; }

Result<ControlSocket> ControlSocket::open(const std::string& record) {
  const auto path = control_socket_path(record);
  const auto refuse = [&](const std::string& why) {
    return failure(FaultKind::storage, path, "operators cannot send requests to this run: " + why);
  };
  const auto address = make_address(path);
  if (!address) return refuse(address.error().what);
  auto socket = make_socket(SOCK_NONBLOCK);
  struct stat found {};
  if (::lstat(path.c_str(), &found) == 0 && S_ISSOCK(found.st_mode)) ::unlink(path.c_str());
  // bind() then never creates a socket with a wider mode, not even for a moment.
  ::fchmod(socket.number(), kOwnerAndGroup);
  if (!socket.is_open() || ::bind(socket.number(), as_sockaddr(*address), sizeof address->text) != 0 ||
      !open_to_owner_and_group(*address, std::filesystem::path(path).filename().string()) ||
      ::listen(socket.number(), kMaxClients) != 0)
    return refuse(std::strerror(errno));
  return ControlSocket(std::move(socket), path);
}

ControlSocket::~ControlSocket() {
  if (socket_.is_open()) ::unlink(path_.c_str());
}

Descriptor ControlSocket::accept() {
  const auto next = [this] {
    return Descriptor(::accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  };
  auto client = next();
  if (client.is_open() || (errno != EMFILE && errno != ENFILE)) return client;
  spare_.is_open() ? spare_.close() : clients_.clear();
  return next();
}

void ControlSocket::listen(const Listener& listener) {
  std::erase_if(clients_, [&](const Descriptor& client) { return !serve_client(client.number(), listener); });
  for (int i = 0; i < kMaxNewClients; ++i) {
    if (!spare_.is_open()) spare_ = spare_descriptor();
    auto client = accept();
    if (!client.is_open()) break;
    // A client whose message is already here does not displace a waiting one.
    if (!serve_client(client.number(), listener)) continue;
    if (clients_.size() >= kMaxClients) clients_.erase(clients_.begin());
    clients_.push_back(std::move(client));
  }
}

namespace {

/// Returns why no program has a socket for this record.
Fault explain_absence(const std::string& record) {
  std::error_code error;
  if (std::filesystem::exists(record, error))
    return {FaultKind::usage, record, "no program is running this run, so no request can be sent"};
  const auto named = record + ".db";
  const bool is_near = std::filesystem::exists(named, error);
  return {FaultKind::bad_file, record,
          "no such file, expected the record of a run in progress" +
              (is_near ? fmt::format("; did you mean \"{}\"?", named) : "")};
}

/// Connects to the socket of a run. If the listen queue is full, which the kernel reports immediately (EAGAIN), retries
/// until the deadline.
Result<Descriptor> connect_to_run(const std::string& record, const Deadline& deadline) {
  const auto path = control_socket_path(record);
  const auto address = make_address(path);
  if (!address) return failure(address.error());
  auto socket = make_socket(SOCK_NONBLOCK);
  while (::connect(socket.number(), as_sockaddr(*address), sizeof address->text) != 0) {
    constexpr int kRetryEveryMs = 50;
    if (errno == ENOENT || errno == ECONNREFUSED) return failure(explain_absence(record));
    if (errno != EAGAIN && errno != EINTR) return failure(FaultKind::refused, path, std::strerror(errno));
    if (deadline.has_passed())
      return failure(FaultKind::timeout, path, "too many clients, or the run does not accept connections");
    ::poll(nullptr, 0, kRetryEveryMs);
  }
  return socket;
}

/// A process and its user.
struct Writer {
  std::int64_t pid{};
  uid_t uid{};
};

std::string describe(const Writer& writer) {
  return fmt::format("process {} of {}", writer.pid, describe_user(writer.uid));
}

/// Returns the process that the status file next to the record names. The owner of that file is its user.
Result<Writer> read_writer(const std::string& record) {
  const auto path = record + kStatusEnding;
  const auto unknown = [&](const std::string& why) {
    return failure(FaultKind::refused, path, fmt::format("does not name the process of the run: {}", why));
  };
  const auto file = open_regular_file(path, Links::refused);
  if (!file) return unknown(file.error().what);
  struct stat found {};
  if (::fstat(file->descriptor.number(), &found) != 0) return unknown(std::strerror(errno));
  const auto status =
      read_whole(*file, path).and_then([&](const std::string& text) { return JsonNode::parse(text, path); });
  if (!status) return unknown(status.error().what);
  const Writer writer{.pid = (*status)["pid"].long_integer(), .uid = found.st_uid};
  if (const auto verdict = status->verdict(); !verdict) return unknown(verdict.error().what);
  return writer;
}

/// Returns true if the user is this user, root, or the owner of the record or of its folder.
bool may_carry_out(uid_t uid, const std::string& record) {
  if (uid == ::geteuid() || uid == 0) return true;
  struct stat found {};
  for (const auto& path : {record, parent_folder(record)})
    if (::stat(path.c_str(), &found) == 0 && found.st_uid == uid) return true;
  return false;
}

/// Fails with refused if the process that listens is not the one that the status file names. The kernel reports the
/// process that called listen().
Result<void> check_listener(const Descriptor& socket, const std::string& record) {
  const auto path = control_socket_path(record);
  const auto peer = read_peer(socket.number());
  if (!peer)
    return failure(FaultKind::refused, path, fmt::format("the listening process is unknown: {}", std::strerror(errno)));
  const auto expected = read_writer(record);
  if (!expected) return failure(expected.error());
  const Writer found{.pid = peer->pid, .uid = peer->uid};
  if (found.pid == expected->pid && found.uid == expected->uid && may_carry_out(found.uid, record)) return {};
  return failure(FaultKind::refused, path,
                 fmt::format("{} listens on this socket, but {} writes the record; nothing was sent to it",
                             describe(found), describe(*expected)));
}

/// Waits until the status file names the listener: a run that starts or resumes listens shortly before that.
Result<void> await_listener(const Descriptor& socket, const std::string& record) {
  auto known = check_listener(socket, record);
  for (const Deadline limit(kNamingTimeout); !known && !limit.has_passed(); known = check_listener(socket, record))
    (void)wait_until_ready(socket.number(), POLLIN, Deadline(kRetryEvery));
  return known;
}

/// Sends a message and returns the answer. Returns nothing if the listener closed the connection before it read the
/// message. It does so with a silent client when it has no descriptors left.
Result<std::optional<ControlAnswer>> exchange(const Descriptor& socket, const std::string& message,
                                              const std::string& path, const Deadline& deadline) {
  if (::send(socket.number(), message.data(), message.size(), MSG_NOSIGNAL) < 0) {
    if (errno == EPIPE || errno == ECONNRESET) return std::nullopt;
    return failure(FaultKind::disconnected, path, std::strerror(errno));
  }
  if (!wait_until_ready(socket.number(), POLLIN, deadline))
    return failure(FaultKind::timeout, path, "the program of the run does not answer");
  std::array<char, kLongestRequest> answer{};
  const auto size = ::recv(socket.number(), answer.data(), answer.size(), 0);
  // The listener closed the connection with the message unread (unix(7)).
  if (size < 0 && errno == ECONNRESET) return std::nullopt;
  if (size <= 0) return failure(FaultKind::disconnected, path, "the program closed the connection without an answer");
  return parse_answer({answer.data(), static_cast<std::size_t>(size)});
}

}  // namespace

Result<ControlAnswer> send_request(const std::string& record, const ControlRequest& request, Duration within) {
  const auto path = control_socket_path(record);
  const Deadline deadline(within);
  while (true) {
    const auto socket = connect_to_run(record, deadline);
    if (!socket) return failure(socket.error());
    if (const auto known = await_listener(*socket, record); !known) return failure(known.error());
    const auto answer = exchange(*socket, to_message(request), path, deadline);
    if (!answer) return failure(answer.error());
    if (*answer) return **answer;
    if (deadline.has_passed())
      return failure(FaultKind::timeout, path, "the program closed the connection before it read the message");
  }
}

}  // namespace gyrotherm::control
