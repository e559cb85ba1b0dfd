/// Time as a command of several steps needs it: what time it is, and letting some pass.
#pragma once

#include <memory>

#include "core/quantity.hpp"

namespace gyrotherm {

class Pauses {
 public:
  virtual ~Pauses() = default;
  [[nodiscard]] virtual Duration now() const = 0;
  virtual void rest(Duration time) = 0;
};

/// The machine's steady clock; a rest keeps the caller's thread.
[[nodiscard]] std::unique_ptr<Pauses> real_pauses();
/// A count that rests add to, for virtual instruments: they take no time, and answer at once.
[[nodiscard]] std::unique_ptr<Pauses> virtual_pauses();

}  // namespace gyrotherm
