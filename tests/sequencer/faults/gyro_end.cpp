// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/gyro_end.hpp"

#include <algorithm>
#include <utility>

namespace gyrotherm::faults {
namespace {

// Exceeds the longest delay of the program, at one frame a second.
constexpr std::size_t kFramesKept = 20000;

/// Returns the index of a name; the last index for a name that the laboratory does not know.
std::size_t find_index(const std::vector<std::string>& all, const std::string& one) {
  return std::min(static_cast<std::size_t>(std::ranges::find(all, one) - all.begin()), all.size() - 1);
}

}  // namespace

GyroEnd::GyroEnd(const rig::GyroLine& settings, const std::vector<rig::UnitSettings>& units,
                 const simulator::VirtualLaboratory& laboratory, const Clock& rig, std::uint64_t seed)
    : laboratory_(laboratory),
      axes_([&] {
        std::vector<Axis> axes;
        for (const auto& share : settings.shares)
          for (const auto& axis : units[share.unit].info.axes) {
            const auto unit = find_index(laboratory.units(), units[share.unit].info.name);
            axes.push_back({unit, find_index(laboratory.axes(unit), axis.name)});
          }
        return axes;
      }()),
      format_(simulator::slow_to_one_frame_per_second(settings.frame)),
      writer_(make_writer()),
      line_(
          rig, seed, [](auto, Bytes&) {}, garble_burst),
      origin_{std::vector<std::int64_t>(axes_.size()), 0} {}

simulator::StreamWriter GyroEnd::make_writer() const {
  return {format_, std::vector<double>(axes_.size(), laboratory_.arcsec_per_pulse())};
}

GyroEnd::Sent GyroEnd::now() const {
  Sent sent{{}, laboratory_.device_time_us(axes_.front().unit)};
  for (const auto& [unit, axis] : axes_) sent.pulses.push_back(laboratory_.pulses(unit)[axis]);
  return sent;
}

void GyroEnd::send_frame() {
  auto sent = now();
  const auto before = std::exchange(before_, sent);
  for (std::size_t i = 0; i < before.pulses.size() && trouble.dead; ++i)
    origin_.pulses[i] += sent.pulses[i] - before.pulses[i];
  sent.device_time_us -= origin_.device_time_us;
  std::vector<double> pulses;
  for (std::size_t i = 0; i < sent.pulses.size(); ++i)
    pulses.push_back(static_cast<double>(sent.pulses[i] -= origin_.pulses[i]));
  auto frame = writer_.next(pulses, sent.device_time_us, 1);
  const auto& of_line = line_.trouble;
  if (laboratory_.is_off(axes_.front().unit) || of_line.gone || of_line.silent || line_.draw_event(trouble.lost))
    return;
  if (line_.draw_event(trouble.garbled)) return garble_burst(frame, line_.random()), line_.arrive(frame);
  held_back_.insert(held_back_.end(), frame.begin(), frame.end());
  held_frames_.push_back(std::move(sent));
  if (trouble.held_back) return;
  line_.arrive(held_back_);
  frames_.insert(frames_.end(), held_frames_.begin(), held_frames_.end());
  held_back_.clear(), held_frames_.clear();
  while (frames_.size() > kFramesKept) frames_.pop_front();
}

void GyroEnd::restart() {
  origin_ = now();
  writer_ = make_writer();
}

bool GyroEnd::matches_sent_counts(const GyroCount& count, std::size_t first) const {
  if (count.interval == Duration::zero()) return std::ranges::all_of(count.pulses, [](auto n) { return n == 0; });
  const auto interval_us = std::chrono::duration_cast<std::chrono::microseconds>(count.interval).count();
  const auto fits = [&](const Sent& from, const Sent& to) {
    if (to.device_time_us - from.device_time_us != interval_us) return false;
    for (std::size_t i = 0; i < count.pulses.size(); ++i)
      if (to.pulses[first + i] - from.pulses[first + i] != count.pulses[i]) return false;
    return true;
  };
  for (auto last = frames_.rbegin(); last != frames_.rend() && last - frames_.rbegin() < 4; ++last)
    for (auto before = last; before != frames_.rend(); ++before)
      if (fits(*before, *last)) return true;
  return false;
}

}  // namespace gyrotherm::faults
