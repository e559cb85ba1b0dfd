// SPDX-License-Identifier: Apache-2.0
#include "tests/sequencer/faults/plant.hpp"

#include <algorithm>
#include <cmath>

#include "core/random.hpp"
#include "simulator/servers/virtual_thermometers.hpp"

namespace gyrotherm::faults {
namespace {

constexpr std::size_t kFramesKept = 20000;  // more than the program is ever late for, one frame a second

simulator::Lakeshore218Session::Inputs inputs_of(const rig::ThermometerSettings& entry,
                                                 const simulator::VirtualLaboratory& laboratory) {
  simulator::Lakeshore218Session::Inputs inputs;
  const auto& names = laboratory.thermometer_names();
  for (std::size_t i = 0; i < entry.channels.size(); ++i)
    inputs[i] = static_cast<std::size_t>(std::ranges::find(names, entry.channels[i]) - names.begin());
  return inputs;
}

}  // namespace

Plant::Plant(const rig::RigFile& file, const simulator::LaboratoryParameters& parameters, const Clock& rig,
             std::uint64_t seed)
    : laboratory_(parameters, {.gyro = 0, .run = seed}),
      registers_(file.chamber_map, laboratory_),
      chamber_port_(registers_, laboratory_, rig, splitmix64(seed)),
      frame_format_(simulator::at_one_frame_a_second(file.gyro.frame)),
      writer_(frame_format_, laboratory_.arcsec_per_pulse()),
      gyro_line_(
          rig, splitmix64(seed + 1), [](auto, Bytes&) {}, garble_burst) {
  for (const auto& entry : file.thermometers) {
    sessions_.push_back(std::make_unique<simulator::Lakeshore218Session>(laboratory_, inputs_of(entry, laboratory_)));
    thermometers_.push_back(std::make_unique<LineEnd>(
        rig, splitmix64(seed + 2 + sessions_.size()),
        [session = sessions_.back().get()](auto sent, Bytes& answer) { (void)session->feed(sent, answer); },
        garble_text));
  }
}

void Plant::pass_second() {
  registers_.pass_second();
  laboratory_.step();
  send_frame();
}

void Plant::send_frame() {
  const auto pulses = laboratory_.pulses() - gyro_origin_.pulses;
  const auto time_us = laboratory_.device_time_us() - gyro_origin_.device_time_us;
  auto frame = writer_.next(static_cast<double>(pulses), time_us, 1);
  const auto& trouble = gyro_line_.trouble;
  if (laboratory_.unit().off || trouble.gone || trouble.silent || gyro_line_.happens(gyro_trouble.lost)) return;
  if (gyro_line_.happens(gyro_trouble.garbled))
    return garble_burst(frame, gyro_line_.random()), gyro_line_.arrive(frame);
  held_back_.insert(held_back_.end(), frame.begin(), frame.end());
  held_frames_.push_back({pulses, time_us});
  if (gyro_trouble.held_back) return;
  gyro_line_.arrive(held_back_);
  frames_.insert(frames_.end(), held_frames_.begin(), held_frames_.end());
  held_back_.clear(), held_frames_.clear();
  while (frames_.size() > kFramesKept) frames_.pop_front();
}

void Plant::restart_gyro() {
  gyro_origin_ = {laboratory_.pulses(), laboratory_.device_time_us()};
  writer_ = simulator::StreamWriter(frame_format_, laboratory_.arcsec_per_pulse());
}

void Plant::restart_chamber(Celsius set_point, bool on) {
  laboratory_.command(set_point);
  laboratory_.switch_on(on);
}

void Plant::write(const char* item, double value) {
  const auto& found = *registers_.map().find(item);
  const auto words = encode(found, value);
  (void)registers_.write(drivers::WriteFunction::registers, found.address, words);
}

bool Plant::was_counted(const PulseCount& count) const {
  if (count.interval == Duration::zero()) return count.pulses == 0;
  const auto interval_us = std::chrono::duration_cast<std::chrono::microseconds>(count.interval).count();
  for (auto last = frames_.rbegin(); last != frames_.rend() && last - frames_.rbegin() < 4; ++last)
    for (auto first = last; first != frames_.rend(); ++first)
      if (last->device_time_us - first->device_time_us == interval_us && last->pulses - first->pulses == count.pulses)
        return true;
  return false;
}

}  // namespace gyrotherm::faults
