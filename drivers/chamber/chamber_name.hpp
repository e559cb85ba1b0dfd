/// A name that one process of the machine's network can have at a time: of the chamber that it drives.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "drivers/line/descriptor.hpp"

namespace gyrotherm {

/// The name of that place, as long as the descriptor is open. Fails with errno, EADDRINUSE if another process has it.
[[nodiscard]] tl::expected<Descriptor, int> take_name(const std::string& place);

/// The process that has a name, by the kernel's word; zeros where it cannot be told.
struct NameOwner {
  std::int64_t pid = 0;
  std::int64_t uid = -1;
};
/// Nothing if no process has the name.
[[nodiscard]] std::optional<NameOwner> owner_of_name(const std::string& place);

}  // namespace gyrotherm
