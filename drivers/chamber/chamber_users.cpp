// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/chamber_users.hpp"

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <linux/sock_diag.h>
#include <linux/unix_diag.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "core/process.hpp"

namespace gyrotherm::drivers {
namespace {

/// Splits a line of passwd(5) or group(5) at its colons.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ':');) fields.push_back(field);
  return fields;
}

bool lists(const std::string& members, const std::string& user) {
  std::istringstream stream(members);
  for (std::string member; std::getline(stream, member, ',');)
    if (member == user) return true;
  return false;
}

/// Returns the number of the user's own group; empty if /etc/passwd has no such user.
std::string own_group_of(std::int64_t uid) {
  std::ifstream users("/etc/passwd");
  for (std::string line; std::getline(users, line);)
    if (const auto fields = fields_of(line); fields.size() > 3 && fields[2] == std::to_string(uid)) return fields[3];
  return {};
}

bool is_member(std::int64_t uid) {
  const auto own = own_group_of(uid);
  if (own.empty()) return false;
  const auto user = user_name(uid);
  std::ifstream groups("/etc/group");
  for (std::string line; std::getline(groups, line);) {
    const auto fields = fields_of(line);
    if (fields.size() < 3 || std::ranges::count(kChamberGroups, fields[0]) == 0) continue;
    if (fields[2] == own || (fields.size() > 3 && lists(fields[3], user))) return true;
  }
  return false;
}

struct Question {
  nlmsghdr header{};
  unix_diag_req request{};
};

/// Reads the user out of an answer of the kernel; nothing if it is an error or has none.
std::optional<std::int64_t> user_in(const char* answer, std::size_t size) {
  nlmsghdr header{};
  if (size < sizeof header) return {};
  std::memcpy(&header, answer, sizeof header);
  if (header.nlmsg_type != SOCK_DIAG_BY_FAMILY) return {};
  const auto end = std::min<std::size_t>(size, header.nlmsg_len);
  for (std::size_t at = NLMSG_LENGTH(sizeof(unix_diag_msg)); at + sizeof(rtattr) <= end;) {
    rtattr attribute{};
    std::memcpy(&attribute, answer + at, sizeof attribute);
    if (attribute.rta_len < sizeof attribute || at + attribute.rta_len > end) return {};
    std::uint32_t uid{};
    if (attribute.rta_type == UNIX_DIAG_UID && attribute.rta_len >= RTA_LENGTH(sizeof uid)) {
      std::memcpy(&uid, answer + at + RTA_LENGTH(0), sizeof uid);
      return uid;
    }
    at += RTA_ALIGN(attribute.rta_len);
  }
  return {};
}

}  // namespace

bool may_hold_chambers(std::int64_t uid) {
  return uid <= 0 || uid == static_cast<std::int64_t>(::geteuid()) || is_member(uid);
}

std::optional<std::int64_t> user_of_socket(std::uint32_t inode) {
  constexpr auto kKernelAnswersWithin = std::chrono::milliseconds(200);
  const Descriptor socket(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_SOCK_DIAG));
  Question question;
  question.header.nlmsg_len = sizeof question;
  question.header.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  question.header.nlmsg_flags = NLM_F_REQUEST;
  question.request.sdiag_family = AF_UNIX;
  question.request.udiag_states = ~0U;
  question.request.udiag_ino = inode;
  question.request.udiag_show = UDIAG_SHOW_UID;
  question.request.udiag_cookie[0] = question.request.udiag_cookie[1] = ~0U;
  if (!socket.is_open() || ::send(socket.number(), &question, sizeof question, 0) < 0) return {};
  if (!ready(socket.number(), POLLIN, Deadline(kKernelAnswersWithin))) return {};
  std::array<char, 1024> answer{};
  const auto size = ::recv(socket.number(), answer.data(), answer.size(), MSG_DONTWAIT);
  return size < 0 ? std::nullopt : user_in(answer.data(), static_cast<std::size_t>(size));
}

}  // namespace gyrotherm::drivers
