#include "drivers/chamber/pauses.hpp"

#include <poll.h>

#include <algorithm>
#include <chrono>

namespace gyrotherm {

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

class RealPauses final : public Pauses {
 public:
  Duration now() const override { return steady_clock::now().time_since_epoch(); }
  void rest(Duration time) override {
    const auto end = now() + time;
    for (auto left = time; left > Duration{}; left = end - now())
      poll(nullptr, 0, static_cast<int>(std::max<std::int64_t>(std::chrono::ceil<milliseconds>(left).count(), 1)));
  }
};

class VirtualPauses final : public Pauses {
 public:
  Duration now() const override { return now_; }
  void rest(Duration time) override { now_ += time; }

 private:
  Duration now_{};
};

}  // namespace

std::unique_ptr<Pauses> real_pauses() { return std::make_unique<RealPauses>(); }
std::unique_ptr<Pauses> virtual_pauses() { return std::make_unique<VirtualPauses>(); }

}  // namespace gyrotherm
