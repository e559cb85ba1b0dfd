// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/sessions.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "apps/monitor/state_folder.hpp"
#include "apps/monitor/users.hpp"
#include "core/json.hpp"
#include "core/sha256.hpp"

namespace gyrotherm::monitor {

inline constexpr const char* kSessionsSchema = "gyrotherm-monitor-sessions/1";

namespace {

/// Removes the oldest entries of a user until fewer than `most` remain. `time` is the member with the time of an entry.
template <class Map, class Time>
void make_room(Map& entries, const std::string& user, std::size_t most, Time time) {
  std::vector<typename Map::iterator> own;
  for (auto entry = entries.begin(); entry != entries.end(); ++entry)
    if (entry->second.user == user) own.push_back(entry);
  std::ranges::sort(own, {}, [time](const auto& entry) { return entry->second.*time; });
  for (std::size_t i = 0; i + most <= own.size(); ++i) entries.erase(own[i]);
}

}  // namespace

void describe(auto& form, Like<Sessions::Session> auto& session) {
  form("id", session.id);
  form("user", session.user);
  form.if_present("known_by", !session.password_id.empty(), session.password_id);
  form("csrf", session.csrf);
  form("begun_utc_ns", session.begun);
  form("used_utc_ns", session.used);
}

Result<void> Sessions::load() {
  const auto text =
      path_.empty() ? Result<std::optional<std::string>>(std::optional<std::string>()) : read_private_file(path_);
  if (!text) return failure(text.error());
  if (!*text) return {};
  const auto root = JsonNode::parse(**text, path_);
  if (!root) return failure(root.error());
  if (const auto schema = (*root)["schema"]; schema.text() != kSessionsSchema)
    schema.note_error(std::string("unknown schema, expected ") + kSessionsSchema);
  std::vector<Session> list;
  read_json((*root)["sessions"], list);
  if (auto verdict = root->verdict(); !verdict) return verdict;
  const std::lock_guard lock(mutex_);
  for (auto& session : list) sessions_.insert_or_assign(session.id, session);
  return {};
}

/// Writes the list. Fails with storage.
Result<void> Sessions::save() {
  if (path_.empty()) return {};
  std::vector<Session> list;
  for (const auto& [id, session] : sessions_) list.push_back(session);
  auto written =
      write_private_file(path_, json_text(Json{{"schema", kSessionsSchema}, {"sessions", make_json(list)}}) + "\n");
  is_stored_ = written.has_value();
  tried_at_ = clock_.now().since_start;
  return written;
}

void Sessions::remove_expired() {
  const auto now = clock_.now().utc;
  std::erase_if(sessions_, [&](const auto& entry) {
    const auto& session = entry.second;
    return now - session.begun > kLifetime || now - session.used > kIdleLifetime || session.begun > now + kSecond;
  });
  while (sessions_.size() > kMaxSessions)
    sessions_.erase(std::ranges::min_element(sessions_, {}, [](const auto& entry) { return entry.second.used; }));
}

std::string Sessions::open(const std::string& user, const std::string& password_id) {
  auto secret = random_secret();
  const std::lock_guard lock(mutex_);
  make_room(sessions_, user, kMaxPerUser, &Session::used);
  const auto now = clock_.now().utc;
  Session session{.id = sha256(secret),
                  .user = user,
                  .password_id = password_id,
                  .csrf = random_secret(),
                  .begun = now,
                  .used = now};
  sessions_.insert_or_assign(session.id, session);
  remove_expired();
  (void)save();
  return secret;
}

std::optional<Sessions::Session> Sessions::find(const std::string& secret) {
  // Length of random_secret().
  constexpr std::size_t kSecretLength = 43;
  if (secret.size() != kSecretLength) return std::nullopt;
  const std::lock_guard lock(mutex_);
  remove_expired();
  const auto now = clock_.now();
  constexpr Duration kSaveInterval = std::chrono::minutes(10), kRetryInterval = std::chrono::minutes(1);
  if (!is_stored_ && now.since_start - tried_at_ >= kRetryInterval) (void)save();
  const auto found = sessions_.find(sha256(secret));
  if (found == sessions_.end()) return std::nullopt;
  if (now.utc - found->second.used > kSaveInterval) {
    found->second.used = now.utc;
    (void)save();
  }
  return found->second;
}

Result<void> Sessions::close(const std::string& id) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(id);
  return save();
}

Result<void> Sessions::close_all_for_user(const std::string& user) {
  const std::lock_guard lock(mutex_);
  std::erase_if(sessions_, [&](const auto& entry) { return entry.second.user == user; });
  return save();
}

Result<void> Sessions::store_again() {
  const std::lock_guard lock(mutex_);
  return is_stored_ ? Result<void>() : save();
}

std::vector<Sessions::Session> Sessions::all() {
  const std::lock_guard lock(mutex_);
  remove_expired();
  std::vector<Session> list;
  for (const auto& [id, session] : sessions_) list.push_back(session);
  return list;
}

namespace {

std::string make_subject(const std::string& user, const std::string& run, const std::string& verb) {
  return user + '\n' + run + '\n' + verb;
}

}  // namespace

std::string Confirmations::issue_token(const std::string& user, const std::string& run, const std::string& verb) {
  const auto subject = make_subject(user, run, verb);
  const std::lock_guard lock(mutex_);
  const auto now = clock_.now().since_start;
  std::erase_if(pending_, [&](const auto& entry) {
    return now - entry.second.issued_at > kLifetime || entry.second.subject == subject;
  });
  make_room(pending_, user, kMaxPerUser, &Pending::issued_at);
  auto token = random_secret();
  pending_[token] = {.user = user, .subject = subject, .issued_at = now};
  return token;
}

bool Confirmations::redeem(const std::string& token, const std::string& user, const std::string& run,
                           const std::string& verb) {
  const std::lock_guard lock(mutex_);
  const auto found = pending_.find(token);
  if (found == pending_.end()) return false;
  const bool good = found->second.subject == make_subject(user, run, verb) &&
                    clock_.now().since_start - found->second.issued_at <= kLifetime;
  pending_.erase(found);
  return good;
}

std::string client_network(const std::string& address) {
  const auto end = address.starts_with('[') ? address.find(']') : address.find(':');
  const bool has_port = address.find(':') == address.rfind(':') || address.starts_with('[');
  const auto host = has_port ? address.substr(0, end) : address;
  const auto bare = host.starts_with('[') ? host.substr(1) : host;
  in6_addr bytes{};
  if (::inet_pton(AF_INET6, bare.c_str(), &bytes) != 1) return bare;
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (IN6_IS_ADDR_V4MAPPED(&bytes)) {
    constexpr std::size_t kIpv4Begin = 12;
    ::inet_ntop(AF_INET, &bytes.s6_addr[kIpv4Begin], text.data(), text.size());
    return text.data();
  }
  constexpr std::size_t kNetworkBytes = 8;
  std::ranges::fill(std::span(bytes.s6_addr).subspan(kNetworkBytes), std::uint8_t{0});
  ::inet_ntop(AF_INET6, &bytes, text.data(), text.size());
  return std::string(text.data()) + "/64";
}

double RateLimit::attempts_left(const Allowance& allowance, Duration now) const {
  return std::min(burst_, allowance.attempts_left + to_seconds(now - allowance.updated_at) * per_second_);
}

/// Removes all names with a whole burst, or else the name with the most attempts left.
void RateLimit::make_room(Duration now) {
  const auto left = [&](const auto& entry) { return attempts_left(entry.second, now); };
  const auto removed = std::erase_if(allowances_, [&](const auto& entry) { return left(entry) >= burst_; });
  if (removed == 0) allowances_.erase(std::ranges::max_element(allowances_, {}, left));
}

bool RateLimit::try_acquire(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.now().since_start;
  if (allowances_.size() >= kMaxNames && !allowances_.contains(name)) make_room(now);
  auto& allowance = allowances_.try_emplace(name, Allowance{.attempts_left = burst_, .updated_at = now}).first->second;
  allowance = {.attempts_left = attempts_left(allowance, now), .updated_at = now};
  if (allowance.attempts_left < 1) return false;
  allowance.attempts_left -= 1;
  return true;
}

}  // namespace gyrotherm::monitor
