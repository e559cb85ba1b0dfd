// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/gyrotherm/real_rig.hpp"

#include <chrono>
#include <cmath>
#include <regex>
#include <thread>

namespace gyrotherm::app {

std::string find_port(const std::string& instrument, const std::string& output) {
  std::smatch match;
  return std::regex_search(output, match, std::regex(instrument + R"( +tcp://127\.0\.0\.1:(\d+))")) ? match[1].str()
                                                                                                    : "";
}

RealLaboratory::RealLaboratory(const std::string& folder)
    : simulate_(std::make_unique<Background>(
          std::vector<std::string>{"simulate", "--rig", "profiles/rigs/virtual.toml"}, folder + "/laboratory.log")) {
  if (!simulate_->wait_for("gyro  ", 60)) return;
  const auto output = simulate_->output();
  chamber_port_ = find_port("chamber", output);
  const auto made =
      shell("/usr/bin/python3 tests/apps/gyrotherm/real_rig.py profiles/rigs/virtual.toml " + chamber_port_ + " " +
            find_port("thermometer 1", output) + " " + find_port("thermometer 2", output) + " " +
            find_port("gyro", output) + " > " + folder + "/rig.toml");
  if (made.exit_code == 0) rig_ = folder + "/rig.toml";
}

std::optional<double> RealLaboratory::set_point() const {
  const auto read = shell("mbpoll -m tcp -a 1 -0 -1 -q -B -t 4:float -r 103 -c 1 -p " + chamber_port_ + " 127.0.0.1");
  std::smatch match;
  if (!std::regex_search(read.out, match, std::regex(R"(\]:\s+(-?[0-9.]+))"))) return {};
  return std::stod(match[1].str());
}

std::optional<double> RealLaboratory::wait_for_set_point(double wanted, double seconds) const {
  using std::chrono::steady_clock;
  const auto began = steady_clock::now();
  const auto passed = [&] { return std::chrono::duration<double>(steady_clock::now() - began).count(); };
  while (passed() < seconds) {
    if (const auto now = set_point(); now && std::abs(*now - wanted) < 0.05) return passed();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return {};
}

}  // namespace gyrotherm::app
