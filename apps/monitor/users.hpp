// SPDX-License-Identifier: Apache-2.0
/// Who may use the page, from a file that gyrotherm-monitor alone writes (mode 0600): names, roles, and what passwords
/// and tokens are known by. A password is kept as libsodium's argon2id, a token as its SHA-256; neither can be read
/// back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/file.hpp"
#include "core/form.hpp"
#include "core/result.hpp"

namespace gyrotherm::monitor {

inline constexpr const char* kUsersSchema = "gyrotherm-monitor-users/1";

/// Each may what the one before may.
enum class Role {
  viewer,         ///< looks
  conductor,      ///< speaks to runs; "operator" in files and on command lines
  administrator,  ///< sees who is logged in, and ends their sessions
};
inline constexpr std::initializer_list<Role> kRoles = {Role::viewer, Role::conductor, Role::administrator};
[[nodiscard]] inline const char* name(Role role) {
  return word_in<Role::administrator>({"viewer", "operator", "administrator"}, role);
}
[[nodiscard]] std::optional<Role> role_named(std::string_view word);

struct User {
  std::string name;
  Role role{};
  std::string password;  ///< as argon2id has it
};
/// A script's.
struct Token {
  std::string name;
  Role role{};
  std::string sha256;  ///< of its text
};

/// Whoever a request comes from.
struct Identity {
  std::string name;
  Role role{};
  std::string known_by{};  ///< of a user: SHA-256 of what the password is kept as, which is another with each password
};

/// What the file holds.
struct UserList {
  std::vector<User> users;
  std::vector<Token> tokens;
};

/// Nobody, where there is no file. Fails with bad_file, also if others than its owner may read it.
[[nodiscard]] Result<UserList> read_users(const std::string& path);
/// Replaces the file as a whole. Fails with storage.
[[nodiscard]] Result<void> write_users(const std::string& path, const UserList& list);

inline constexpr std::size_t kShortestPassword = 10, kLongestPassword = 256;  ///< bytes

/// Adds a user, or gives one another role and password. Fails with usage: a name that is none, a password too short.
[[nodiscard]] Result<void> put_user(UserList& list, const std::string& name, Role role, const std::string& password);
/// Adds a token or replaces the one of that name; its text, which nobody can tell again. Fails with usage.
[[nodiscard]] Result<std::string> put_token(UserList& list, const std::string& name, Role role);
/// Of a user or a token. Fails with usage if there is none.
[[nodiscard]] Result<void> remove_name(UserList& list, const std::string& name);

/// 256 random bits as 43 characters of URL-safe base 64.
[[nodiscard]] std::string random_secret();
/// Compares in a time that does not depend on where they differ.
[[nodiscard]] bool equal_secrets(std::string_view a, std::string_view b);

/// The users of a running monitor; the file is read anew when it has changed. Any thread.
class Users {
 public:
  explicit Users(std::string path) : path_(std::move(path)) {}

  /// Fails as read_users() does.
  [[nodiscard]] Result<void> load();
  /// Whether there is anybody, or a file that cannot be read.
  [[nodiscard]] bool has_any();
  /// Takes about a tenth of a second and 12 MB, one at a time, and as long for a name that there is not.
  [[nodiscard]] std::optional<Identity> of_password(const std::string& name, const std::string& password);
  [[nodiscard]] std::optional<Identity> of_token(std::string_view token);
  /// A user by name, with the role of now.
  [[nodiscard]] std::optional<Identity> of_name(const std::string& name);

 private:
  void refresh();

  std::string path_;
  std::mutex mutex_, one_at_a_time_;
  UserList list_;
  bool broken_{};   ///< the file is there and cannot be read
  FileState seen_;  ///< of the file as it was read
};

}  // namespace gyrotherm::monitor
