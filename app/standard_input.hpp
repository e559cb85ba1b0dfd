/// Standard input as it arrives: all that is ready at once, and never a wait for more than that.
#pragma once

#include <string>
#include <string_view>

#include "core/result.hpp"

namespace gyrotherm {

class StandardInput {
 public:
  /// Waits until there is input, then takes what is ready, at most a megabyte. Empty at the end of the input and once
  /// the user has asked for a stop. Fails with storage. The text lasts until the next call.
  [[nodiscard]] Result<std::string_view> next();

 private:
  std::string buffer_;
};

}  // namespace gyrotherm
