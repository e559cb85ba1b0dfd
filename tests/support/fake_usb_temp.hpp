// SPDX-License-Identifier: Apache-2.0
/// Fake USB-TEMP that exchanges HID reports. It works until a member function makes it fail.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drivers/thermometer/mcc_usb_temp.hpp"
#include "drivers/wires.hpp"

namespace gyrotherm::tests {

class FakeUsbTemp final : public drivers::HidReports {
 public:
  using Report = std::vector<std::byte>;

  std::array<float, drivers::kMccInputs> temperatures{20.125f, 21.125f, 22.125f, 23.125f,
                                                      24.125f, 25.125f, 26.125f, 27.125f};
  std::vector<std::uint8_t> date{24, 5, 17, 10, 30, 0};
  /// Item settings by converter and sub-item.
  std::map<std::pair<std::uint8_t, std::uint8_t>, std::vector<std::uint8_t>> items;
  std::vector<drivers::MccRequest> heard;
  int openings = 0;
  int status_reads_of_a_calibration = 2;

  void unplug() { plugged_ = open_ = false, waiting_.clear(); }
  void plug_in() { plugged_ = true; }
  void fall_silent() { silent_ = true; }
  /// Answers each query with the answer to the previous one.
  void answer_late() { late_ = true; }
  /// Ignores new settings.
  void forget_settings() { deaf_ = true; }
  void cut_reports() { cut_ = true; }
  void recover() { silent_ = late_ = deaf_ = cut_ = false; }
  void leave(Report report) { waiting_.push_back(std::move(report)); }
  [[nodiscard]] int count(drivers::MccCommand command) const {
    return static_cast<int>(std::ranges::count(heard, command, &drivers::MccRequest::command));
  }

  Result<std::string> open() override {
    if (!plugged_) return failure(FaultKind::disconnected, "hid", "no USB-TEMP is there");
    openings += !std::exchange(open_, true);
    return "USB-TEMP 01234567";
  }
  Result<void> write(std::span<const std::byte> report) override {
    if (auto opened = open(); !opened) return failure(opened.error());
    if (report.size() < 2) return failure(FaultKind::disconnected, "hid", "hidraw takes no report of one byte");
    const auto request = drivers::decode_mcc_request(report);
    if (!request) return failure(request.error());
    heard.push_back(*request);
    auto answer = answer_to(*request);
    if (cut_ && !answer.empty()) answer.pop_back();
    if (late_) std::swap(answer, delayed_);
    if (!answer.empty() && !silent_) waiting_.push_back(std::move(answer));
    return {};
  }
  Result<std::size_t> read(std::span<std::byte> report, Duration) override {
    if (auto opened = open(); !opened) return failure(opened.error());
    if (waiting_.empty()) return failure(FaultKind::timeout, "hid", "no report");
    const auto next = std::move(waiting_.front());
    waiting_.pop_front();
    std::ranges::copy(next, report.begin());
    return next.size();
  }

 private:
  Report answer_to(const drivers::MccRequest& request) {
    const auto& a = request.arguments;
    switch (request.command) {
      case drivers::MccCommand::scan:
        return encode_mcc_numbers(request.command, std::span(temperatures).subspan(a[0], 1u + a[1] - a[0]));
      case drivers::MccCommand::read_memory: return encode_mcc_bytes(request.command, date);
      case drivers::MccCommand::set_item:
        if (!deaf_ && calibrating_ == 0) items[{a[0], a[1]}].assign(a.begin() + 2, a.end());
        return {};
      case drivers::MccCommand::read_item: {
        auto value = items[{a[0], a[1]}];
        value.resize(mcc_reply_length(request));
        return encode_mcc_bytes(request.command, value);
      }
      case drivers::MccCommand::calibrate: calibrating_ = status_reads_of_a_calibration; return {};
      case drivers::MccCommand::read_status: {
        const std::array busy{static_cast<std::uint8_t>(calibrating_ > 0)};
        calibrating_ = std::max(calibrating_ - 1, 0);
        return encode_mcc_bytes(request.command, busy);
      }
      default: return {};
    }
  }

  std::deque<Report> waiting_;
  Report delayed_;
  int calibrating_ = 0;
  bool plugged_ = true, open_ = false, silent_ = false, late_ = false, deaf_ = false, cut_ = false;
};

}  // namespace gyrotherm::tests
