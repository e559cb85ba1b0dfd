/// Users of this machine by name.
#pragma once

#include <cstdint>
#include <string>

namespace gyrotherm {

/// "ada (uid 1000)", or "unknown (uid 1000)" where /etc/passwd has no such user. Directory services are not asked: one
/// that does not answer would hold whoever drives a chamber.
[[nodiscard]] std::string user_in_words(std::int64_t uid);

}  // namespace gyrotherm
