// SPDX-License-Identifier: Apache-2.0
#include "apps/monitor/users.hpp"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <array>

#include "apps/monitor/state_folder.hpp"
#include "core/file.hpp"
#include "core/json.hpp"
#include "core/process.hpp"
#include "core/sha256.hpp"
#include "sequencer/control/control_message.hpp"

namespace gyrotherm::monitor {

void describe(auto& form, Like<User> auto& user) {
  form("name", user.name);
  form("role", one_of(user.role, kRoles));
  form("password", user.password);
}
void describe(auto& form, Like<Token> auto& token) {
  form("name", token.name);
  form("role", one_of(token.role, kRoles));
  form("sha256", token.sha256);
}
void describe(auto& form, Like<UserList> auto& list) {
  form.derived("schema", kUsersSchema);
  form("users", list.users);
  form("tokens", list.tokens);
}

namespace {

// OWASP recommends 12 MB and three passes for argon2id. The monitor may use 64 MB in total.
constexpr unsigned long long kPasses = 3;
constexpr std::size_t kMemoryBytes = std::size_t{12} * 1024 * 1024;

void initialise_sodium() {
  static const int ready = sodium_init();
  ensure(ready >= 0, "libsodium has random numbers");
}

std::string hash_password(const std::string& password) {
  initialise_sodium();
  std::array<char, crypto_pwhash_STRBYTES> text{};
  const int made = crypto_pwhash_str_alg(text.data(), password.data(), password.size(), kPasses, kMemoryBytes,
                                         crypto_pwhash_ALG_ARGON2ID13);
  ensure(made == 0, "a password can be hashed");
  return text.data();
}

bool matches_hash(const std::string& hash, const std::string& password) {
  initialise_sodium();
  return crypto_pwhash_str_verify(hash.c_str(), password.data(), password.size()) == 0;
}

Result<void> check_name(const std::string& name) {
  if (control::is_user_name(name)) return {};
  return failure(FaultKind::usage, fmt::format("\"{}\"", name),
                 "expected a name of 1 to 64 letters, digits and _ . @ -");
}

Identity make_identity(const User& user) {
  return {.name = user.name, .role = user.role, .password_id = sha256(user.password)};
}

bool has_name(const UserList& list, const std::string& name) {
  return std::ranges::find(list.users, name, &User::name) != list.users.end() ||
         std::ranges::find(list.tokens, name, &Token::name) != list.tokens.end();
}

}  // namespace

std::optional<Role> find_role(std::string_view keyword) {
  for (const auto role : kRoles)
    if (keyword == name(role)) return role;
  return std::nullopt;
}

Result<UserList> read_users(const std::string& path) {
  const auto text = read_private_file(path);
  if (!text) return failure(text.error());
  UserList list;
  if (!*text) return list;
  const auto root = JsonNode::parse(**text, path);
  if (!root) return failure(root.error());
  if (const auto schema = (*root)["schema"]; schema.text() != kUsersSchema)
    schema.note_error(std::string("unknown schema, expected ") + kUsersSchema);
  read_json(*root, list);
  if (const auto verdict = root->verdict(); !verdict) return failure(verdict.error());
  return list;
}

Result<void> write_users(const std::string& path, const UserList& list) {
  return write_private_file(path, json_text(make_json(list), 1) + "\n");
}

Result<void> add_or_replace_user(UserList& list, const std::string& name, Role role, const std::string& password) {
  if (auto good = check_name(name); !good) return good;
  if (password.size() < kMinPasswordBytes || password.size() > kMaxPasswordBytes)
    return failure(
        FaultKind::usage, "password",
        fmt::format("has {} bytes, expected {} to {}", password.size(), kMinPasswordBytes, kMaxPasswordBytes));
  if (std::ranges::find(list.tokens, name, &Token::name) != list.tokens.end())
    return failure(FaultKind::usage, name, "is the name of a token");
  std::erase_if(list.users, [&](const User& user) { return user.name == name; });
  list.users.push_back({.name = name, .role = role, .password = hash_password(password)});
  return {};
}

Result<std::string> add_or_replace_token(UserList& list, const std::string& name, Role role) {
  if (auto good = check_name(name); !good) return failure(good.error());
  if (std::ranges::find(list.users, name, &User::name) != list.users.end())
    return failure(FaultKind::usage, name, "is the name of a user");
  std::erase_if(list.tokens, [&](const Token& token) { return token.name == name; });
  auto secret = random_secret();
  list.tokens.push_back({.name = name, .role = role, .sha256 = sha256(secret)});
  return secret;
}

Result<void> remove_user_or_token(UserList& list, const std::string& name) {
  if (!has_name(list, name)) return failure(FaultKind::usage, name, "is neither a user nor a token");
  std::erase_if(list.users, [&](const User& user) { return user.name == name; });
  std::erase_if(list.tokens, [&](const Token& token) { return token.name == name; });
  return {};
}

std::string random_secret() {
  initialise_sodium();
  std::array<unsigned char, 32> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  constexpr int kKind = sodium_base64_VARIANT_URLSAFE_NO_PADDING;
  std::array<char, sodium_base64_ENCODED_LEN(32, kKind)> text{};
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), kKind);
  return text.data();
}

bool equal_secrets(std::string_view a, std::string_view b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

Result<void> Users::load() {
  const std::lock_guard lock(mutex_);
  auto list = read_users(path_);
  if (!list) return failure(list.error());
  list_ = std::move(*list);
  return {};
}

/// If the file cannot be read, all logins fail, and guests are refused.
void Users::refresh() {
  const auto now = read_file_state(path_);
  if (now == file_state_) return;
  file_state_ = now;
  auto list = read_users(path_);
  is_unreadable_ = !list;
  list_ = list ? std::move(*list) : UserList{};
}

bool Users::has_any() {
  const std::lock_guard lock(mutex_);
  refresh();
  return is_unreadable_ || !list_.users.empty() || !list_.tokens.empty();
}

std::optional<Identity> Users::find_by_password(const std::string& name, const std::string& password) {
  if (password.size() > kMaxPasswordBytes) return std::nullopt;
  std::optional<User> user;
  {
    const std::lock_guard lock(mutex_);
    refresh();
    const auto found = std::ranges::find(list_.users, name, &User::name);
    if (found != list_.users.end()) user = *found;
  }
  static const std::string unused_hash = hash_password(random_secret());
  const std::lock_guard one(hashing_mutex_);
  const bool is_correct = matches_hash(user ? user->password : unused_hash, password);
  if (!user || !is_correct) return std::nullopt;
  return make_identity(*user);
}

std::optional<Identity> Users::find_by_token(std::string_view token) {
  const auto digest = sha256(token);
  const std::lock_guard lock(mutex_);
  refresh();
  std::optional<Identity> found;
  for (const auto& known : list_.tokens)
    if (equal_secrets(known.sha256, digest)) found = Identity{.name = known.name, .role = known.role};
  return found;
}

std::optional<Identity> Users::find_by_name(const std::string& name) {
  const std::lock_guard lock(mutex_);
  refresh();
  const auto found = std::ranges::find(list_.users, name, &User::name);
  if (found == list_.users.end()) return std::nullopt;
  return make_identity(*found);
}

}  // namespace gyrotherm::monitor
