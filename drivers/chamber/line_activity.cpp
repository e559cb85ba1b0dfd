#include "drivers/chamber/line_activity.hpp"

#include <algorithm>
#include <utility>

namespace gyrotherm {
namespace {

constexpr Duration kPieceOfARest = std::chrono::milliseconds(500);

class NotingRegisters final : public Registers {
 public:
  NotingRegisters(std::unique_ptr<Registers> registers, std::shared_ptr<LineActivity> activity)
      : registers_(std::move(registers)), activity_(std::move(activity)) {}

  Result<std::vector<std::uint16_t>> read(ReadFunction function, std::uint16_t address, std::uint16_t count) override {
    auto words = registers_->read(function, address, count);
    activity_->note();
    return words;
  }
  Result<void> write(WriteFunction function, std::uint16_t address, std::span<const std::uint16_t> words) override {
    auto done = registers_->write(function, address, words);
    activity_->note();
    return done;
  }
  void insist() override { registers_->insist(); }

 private:
  std::unique_ptr<Registers> registers_;
  std::shared_ptr<LineActivity> activity_;
};

class NotingPauses final : public Pauses {
 public:
  NotingPauses(std::unique_ptr<Pauses> pauses, std::shared_ptr<LineActivity> activity)
      : pauses_(std::move(pauses)), activity_(std::move(activity)) {}

  Duration now() const override { return pauses_->now(); }
  void rest(Duration time) override {
    for (; time > Duration{}; time -= kPieceOfARest) {
      pauses_->rest(std::min(time, kPieceOfARest));
      activity_->note();
    }
  }

 private:
  std::unique_ptr<Pauses> pauses_;
  std::shared_ptr<LineActivity> activity_;
};

}  // namespace

std::unique_ptr<Registers> noting(std::unique_ptr<Registers> registers, std::shared_ptr<LineActivity> activity) {
  return std::make_unique<NotingRegisters>(std::move(registers), std::move(activity));
}

std::unique_ptr<Pauses> noting(std::unique_ptr<Pauses> pauses, std::shared_ptr<LineActivity> activity) {
  return std::make_unique<NotingPauses>(std::move(pauses), std::move(activity));
}

}  // namespace gyrotherm
