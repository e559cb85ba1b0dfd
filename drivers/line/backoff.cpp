#include "drivers/line/backoff.hpp"

namespace gyrotherm {

void Backoff::failed() {
  using std::chrono::milliseconds;
  constexpr Duration kFirst = milliseconds(500), kLongest = milliseconds(10'000);
  if (++failures_ < 2) return;
  rest_ = std::clamp(2 * rest_, kFirst, kLongest);
  next_ = Deadline(rest_);
}

}  // namespace gyrotherm
