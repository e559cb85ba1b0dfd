/// Whether calls on a line still get on. One call may take many exchanges, each of which has an end of its own; on a
/// bad line they add up to many seconds, and are no hang.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>

#include "core/quantity.hpp"
#include "drivers/wires.hpp"

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

/// Written by the thread that makes the calls, read by any.
class LineActivity {
 public:
  /// An exchange has ended, well or badly, or a part of a rest is over.
  void note() { last_ = now(); }
  /// How long ago that was.
  [[nodiscard]] Duration quiet_for() const { return now() - last_.load(); }

 private:
  [[nodiscard]] static Duration now() { return std::chrono::steady_clock::now().time_since_epoch(); }
  std::atomic<Duration> last_{now()};
};

/// The same registers; each use that comes back is noted.
[[nodiscard]] std::unique_ptr<Registers> noting(std::unique_ptr<Registers> registers,
                                                std::shared_ptr<LineActivity> activity);
/// The same pauses; a long rest is noted each half second.
[[nodiscard]] std::unique_ptr<Pauses> noting(std::unique_ptr<Pauses> pauses, std::shared_ptr<LineActivity> activity);

}  // namespace gyrotherm
