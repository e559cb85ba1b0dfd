// SPDX-License-Identifier: Apache-2.0
/// A rig whose chamber is virtual and answers by Modbus TCP on loopback, and a person who turns its limiter.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "sequencer/prove/chamber_snapshot.hpp"
#include "sequencer/prove/driven_child.hpp"
#include "sequencer/prove/limiter_proof.hpp"
#include "sequencer/prove/make_safe_proof.hpp"
#include "sequencer/rig/rig.hpp"

namespace gyrotherm::prove {

inline rig::RigFile read_limiter_rig(const std::string& more = "") {
  const std::string file = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml";
  auto text = read_text_file(file).value();
  const std::string map = "chambers/virtual.toml";
  text.replace(text.find(map), map.size(), "chambers/virtual_limiter.toml");
  text.insert(text.find("[[thermometer]]"), more);
  return rig::parse_rig(text, file).value();
}

/// Returns the virtual rig with another map of the chamber and without a watch of the air.
inline rig::RigFile read_rig_with_map(const std::string& path) {
  const std::string file = GYROTHERM_SOURCE_DIR "/profiles/rigs/virtual.toml";
  auto text = read_text_file(file).value();
  const std::string map = "../chambers/virtual.toml";
  text.replace(text.find(map), map.size(), path);
  text.insert(text.find("[[thermometer]]"), "[safe]\nobserve = \"0 s\"\n\n");
  auto rig = rig::parse_rig(text, file);
  EXPECT_TRUE(rig) << gyrotherm::text(rig.error());
  return std::move(*rig);
}

/// Virtual time unless `is_real_time`: each wait advances the laboratory by the time.
class ProveBench {
 public:
  /// `serial` selects a pseudo-terminal with this link of the map.
  explicit ProveBench(rig::RigFile file, bool is_real_time = false, std::optional<drivers::LinkKind> serial = {})
      : rig(std::move(file)),
        instruments(rig::serve_virtual(rig, {}, {.ptys = serial.has_value()}).value()),
        is_real_time_(is_real_time) {
    rig.chamber_line = "tcp://127.0.0.1:" + std::to_string(instruments->chamber_port());
    if (serial) {
      for (const auto& served : instruments->lines())
        if (served.instrument == "chamber" && served.line.starts_with("serial:")) rig.chamber_line = served.line;
      rig.chamber_map = select_link(rig.chamber_map, *serial).value();
    }
    rig.simulated = false;
    if (rig.safe_also) rig.safe_also->line = "tcp://127.0.0.1:" + std::to_string(instruments->relay_port());
  }

  DrillEnvironment environment() {
    return {.clock = is_real_time_ ? static_cast<const Clock&>(steady_) : clock_,
            .wait = [this](Duration time) { wait(time); },
            .is_interrupted = [this] { return clock_.now().since_start >= interrupted_after; },
            .ask = [this](const std::string& question) { return answer(question); },
            .say = [](const std::string&) {},
            .connect = [this] { return connect_chamber(rig); }};
  }
  GuardedHeating guarded() {
    return {.begin = [this]() -> Result<void> { return ++guards_begun, Result<void>(); },
            .end = [this] { ++guards_ended; }};
  }
  ChamberState chamber() { return connect_chamber(rig)->inspect().value(); }
  /// Returns the content of all registers that can be written, as one text.
  std::string registers() {
    const auto [registers, chamber] = connect_with_registers(rig);
    const auto snapshot = ChamberSnapshot::take(rig.chamber_map, *registers, *chamber).value();
    std::string all;
    const auto now = snapshot.compare(*registers).value();
    for (const auto& one : now) all += one.item + "=" + one.after + "\n";
    return all;
  }
  void wait(Duration time) {
    if (is_real_time_) std::this_thread::sleep_for(time);
    clock_.advance(time);
    instruments->pass(is_real_time_ ? time * 20 : time);
  }

  rig::RigFile rig;
  std::unique_ptr<simulator::VirtualInstruments> instruments;
  /// Setting of the limiter during the test and afterwards. The person sets nothing else.
  double low_c = 30, usual_c = 80;
  bool resets = true, obeys = true;
  std::vector<std::string> questions;
  Duration interrupted_after = Duration::max();
  int guards_begun = 0, guards_ended = 0;

 private:
  bool answer(const std::string& question) {
    questions.push_back(question);
    if (!obeys) return false;
    const bool is_first = questions.size() == 1;
    const auto registers = connect_registers(rig);
    const auto& map = rig.chamber_map;
    const auto write = [&](const char* name, double value) {
      const auto& item = *map.find(name);
      EXPECT_TRUE(
          registers->write(write_function(item.write_function, word_count(item)), item.address, encode(item, value)));
    };
    write("limiter_setting", is_first ? low_c : usual_c);
    if (!is_first && resets) write("limiter_reset", 1);
    return true;
  }

  bool is_real_time_;
  SteadyClock steady_;
  VirtualClock clock_;
};

}  // namespace gyrotherm::prove
