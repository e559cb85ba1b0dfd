#include "sequencer/run/record_start.hpp"

#include <fmt/format.h>

#include <random>

#include "core/sha256.hpp"

namespace gyrotherm {
namespace {

std::string drawn_id() {
  std::random_device device;
  return fmt::format("{:08x}{:08x}{:08x}{:08x}", device(), device(), device(), device());
}

std::string derived_id(const RunInfo& info) {
  const auto all = fmt::format("{}\n{}\n{}\n{}\n{}\n{}", info.program_version, info.profile_text, info.rig_text,
                               info.chamber_map_text, info.gyro_model_text, info.seed);
  return sha256(info.gyro_stream_text.empty() ? all : all + "\n" + info.gyro_stream_text).substr(0, 32);
}

}  // namespace

RunInfo run_info(std::string_view program_version, const Profile& profile, const RigFile& rig, std::uint64_t seed,
                 Duration started_utc) {
  RunInfo info;
  info.program_version = program_version;
  info.profile_name = profile.name;
  info.profile_text = profile.text;
  info.rig_name = rig.name;
  info.rig_text = rig.text;
  info.chamber_map_text = rig.chamber_map.text;
  if (rig.gyro.stream) info.gyro_stream_text = rig.gyro.stream->text;
  info.gyro_model = rig.gyro_model.name;
  info.gyro_film = rig.gyro_model.film;
  info.gyro_model_text = rig.gyro_model.text;
  info.simulated = rig.simulated;
  info.seed = seed;
  info.started_utc = started_utc;
  info.thermometers = channels_of(rig);
  info.chamber_instrument = fmt::format("{} at {}", rig.chamber_map.name, rig.chamber_line);
  info.gyro = rig.gyro.info;
  info.gyro.instrument = fmt::format("{} at {}", rig.gyro.stream ? rig.gyro.stream->name : "gyro", rig.gyro.line);
  info.gradients = rig.gradients;
  info.three_point = rig.three_point;
  info.cycles = profile.cycles;
  for (const auto& segment : profile.segments)
    info.segments.push_back({.name = segment.name,
                             .hold = segment.kind == SegmentKind::hold,
                             .target = segment.target,
                             .rate = segment.rate,
                             .cycle = segment.cycle});
  info.id = rig.simulated ? derived_id(info) : drawn_id();
  return info;
}

std::uint64_t run_number(const std::string& profile_text) {
  constexpr int kHexadecimal = 16;
  return std::stoull(sha256(profile_text).substr(0, 16), nullptr, kHexadecimal);
}

}  // namespace gyrotherm
