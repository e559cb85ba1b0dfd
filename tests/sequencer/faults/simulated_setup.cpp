#include "tests/sequencer/faults/simulated_setup.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "core/clock.hpp"
#include "core/file.hpp"
#include "sequencer/run/record_start.hpp"

namespace gyrotherm {
namespace {

template <class T>
T expected(Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}\n", text(result.error()));
  std::abort();
}

std::string from(const std::string& path) { return std::string(GYROTHERM_SOURCE_DIR "/") + path; }

}  // namespace

RunInfo info_of(const Profile& profile, const RigFile& file) { return run_info("", profile, file, 0, kVirtualEpoch); }

SimulatedSetup simulated_setup(const std::string& profile) {
  const auto rig_path = from("profiles/rigs/virtual-reference.toml");
  const auto rig_text = expected(read_text_file(rig_path));
  const auto map_text = expected(read_text_file(from("tests/sequencer/faults/chamber.toml")));
  SimulatedSetup ground;
  ground.profile = expected(parse_profile(expected(read_text_file(from(profile))), profile));
  ground.tcp = expected(parse_rig(rig_text, rig_path, {.chamber_map = map_text, .gyro_model = {}}));
  ground.rtu = ground.tcp;
  ground.rtu.chamber_map = expected(on_link(ground.tcp.chamber_map, LinkKind::rtu));
  ground.laboratory = expected(parse_laboratory(rig_text, rig_path));
  return ground;
}

}  // namespace gyrotherm
