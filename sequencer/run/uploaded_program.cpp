// SPDX-License-Identifier: Apache-2.0
#include "sequencer/run/uploaded_program.hpp"

#include <fmt/format.h>

#include <cctype>
#include <chrono>
#include <optional>

namespace gyrotherm::run {
namespace {

/// This is longer than a status may be old, and than the controller's clock may be ahead.
constexpr Duration kGoneForGood = std::chrono::seconds(60);

/// A program that is held at the panel does not get on; of one that cannot be seen nothing is known.
bool may_get_on(ChamberActivity activity) {
  if (activity == ChamberActivity::holding) return false;
  return activity == ChamberActivity::unknown || carries_out_program(activity);
}

std::string capitals(const std::string& name) {
  std::string all;
  for (const unsigned char c : name)
    if (std::isalnum(c) != 0) all += static_cast<char>(std::toupper(c));
  return all.empty() ? "PROFILE" : all;
}

}  // namespace

Result<drivers::ChamberProgram> program_of(const profile::Profile& profile) {
  drivers::ChamberProgram program{.name = capitals(profile.name), .number = 1, .soak_band = {}, .steps = {}};
  std::optional<Kelvins> band;
  for (std::size_t i = 0; i < profile.segments.size(); ++i) {
    const auto& segment = profile.segments[i];
    drivers::ProgramStep step{
        .kind = segment.kind == profile::SegmentKind::ramp ? drivers::StepKind::ramp : drivers::StepKind::soak,
        .start = segment.kind == profile::SegmentKind::ramp ? set_point_before(profile, i) : segment.target,
        .target = segment.target,
        .duration = shortest(segment),
        .guaranteed_soak = segment.guaranteed_soak};
    if (segment.guaranteed_soak && band && *band != segment.soak_band)
      return failure(FaultKind::usage, segment.place, "a controller has one soak band for the whole profile");
    if (segment.guaranteed_soak) band = segment.soak_band;
    if (step.duration > Duration{}) program.steps.push_back(step);
  }
  program.soak_band = band.value_or(Kelvins{});
  return program;
}

std::string ControllerLead::objection(OperatorCommand command) const {
  if (command != OperatorCommand::pause) return {};
  return "the controller carries the profile out; only its panel can pause it";
}

std::string ControllerLead::judge(const LeadSecond& second) {
  const auto& chamber = second.sample.chamber.value;
  if (!chamber) return {};
  const bool gets_on = second.in_last_segment || may_get_on(chamber->activity);
  gone_ = gets_on ? Duration{} : gone_ + kSecond + second.missed;
  if (gone_ < kGoneForGood) return {};
  return fmt::format("the controller has not carried out its program for {}: {}", spoken(gone_),
                     name(chamber->activity));
}

void ControllerLead::inform(const LeadSecond& second, interlocks::InterlockInputs& inputs) {
  inputs.led_by_controller = true;
  inputs.program = judge(second);
}

interlocks::InterlockDemand ControllerLead::weigh(interlocks::InterlockDemand demand, const LeadSecond&) {
  return demand.reaction < interlocks::Reaction::abort ? interlocks::InterlockDemand{} : demand;
}

std::optional<std::string> ControllerLead::command(io::InstrumentIo& io, const LeadSecond& second, RunState state, bool,
                                                   const interlocks::InterlockMemory&) {
  if (state != RunState::stopped) return std::nullopt;
  const auto held = io.command(second.goal);
  return held ? std::nullopt : std::optional(text(held.error()));
}

}  // namespace gyrotherm::run
