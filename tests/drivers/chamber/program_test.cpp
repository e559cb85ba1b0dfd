// SPDX-License-Identifier: Apache-2.0
#include "drivers/chamber/program.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "core/file.hpp"
#include "drivers/chamber/register_map.hpp"
#include "tests/drivers/chamber/two_registers.hpp"
#include "tests/drivers/line/words.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

RegisterMap shipped(const std::string& name) {
  const auto text = read_text_file(GYROTHERM_SOURCE_DIR "/profiles/chambers/" + name + ".toml");
  return parse_register_map(text.value(), name).value();
}

/// Registers of a profile memory.
class Paper {
 public:
  explicit Paper(const ProfileMemory& memory) : memory_(memory) {}
  void write(const std::vector<MemoryWrite>& writes) {
    for (const auto& one : writes)
      for (std::size_t i = 0; i < one.words.size(); ++i)
        words_[{memory_.stride == 0 ? one.step : 0, one.address + static_cast<int>(i)}] = one.words[i];
  }
  [[nodiscard]] BlockWords read() const {
    return [this](const MemoryBlock& block, int step) -> Result<Words> {
      Words words;
      for (int i = 0; i < block.count; ++i) {
        const auto at = block.address + std::max(step, 0) * memory_.stride + i;
        const auto found = words_.find({memory_.stride == 0 ? step : 0, at});
        words.push_back(found == words_.end() ? std::uint16_t{0} : found->second);
      }
      return words;
    };
  }

 private:
  const ProfileMemory& memory_;
  std::map<std::pair<int, int>, std::uint16_t> words_;
};

TEST(ProgramMemory, HoldsThePublishedFramesOfTheEzt570i) {
  const auto map = shipped("csz_ezt570i");
  const ChamberProgram program{.name = "JESD22A",
                               .number = 1,
                               .soak_band = {1.0},
                               .steps = {{StepKind::soak, {-40}, {-40}, hours(1) + minutes(30), true}}};
  const auto writes = encode_program(*map.memory, program);
  ASSERT_TRUE(writes) << text(writes.error());
  ASSERT_EQ(writes->size(), 2u);
  EXPECT_EQ((*writes)[0].address, 200);
  EXPECT_EQ((*writes)[0].words, (Words{0, 0, 0, 0, 0x454A, 0x4453, 0x3232, 0x2041, 0x2020, 1, 10, 0, 0, 0, 0}));
  EXPECT_EQ((*writes)[1].address, 215);
  EXPECT_EQ((*writes)[1].words, (Words{1, 0x1E00, 1, 0, 1, 0, 0, 0, 1, 0, 0xFE70, 0, 0, 0, 0}));
}

TEST(ProgramMemory, DecodesStoredProgramOfEachController) {
  std::mt19937 random(3);
  const ContextOf one_decimal = [](const RegisterItem&) { return ItemContext{.decimals = 1, .fahrenheit = false}; };
  for (const auto* name : {"csz_ezt570i", "watlow_f4", "watlow_f4t", "binder_mb2"}) {
    const auto map = shipped(name);
    for (int round = 0; round < 100; ++round) {
      ChamberProgram program{.name = "PROFILE", .number = 2, .soak_band = {}, .steps = {}};
      Celsius at{20};
      for (int i = 0, count = 1 + static_cast<int>(random() % 20); i < count; ++i) {
        // A separate kind for each step, because a controller without kinds identifies a soak by its target.
        const bool ramp = random() % 2 == 0;
        const Celsius target = ramp ? Celsius{at.value + 0.1 * static_cast<double>(1 + random() % 300)} : at;
        program.steps.push_back(
            {ramp ? StepKind::ramp : StepKind::soak, at, target, seconds(1 + random() % 30000), false});
        at = target;
        if (at.value > 100) at = {20}, program.steps.back().target = {20}, program.steps.back().kind = StepKind::ramp;
      }
      const auto writes = encode_program(*map.memory, program, one_decimal);
      ASSERT_TRUE(writes) << name << ", seed 3, " << round << ": " << text(writes.error());
      Paper paper(*map.memory);
      paper.write(*writes);
      // The end step of an edit window exists without being written.
      if (map.memory->stride == 0)
        paper.write({{.address = 4003, .words = {5}, .function = {}, .step = static_cast<int>(program.steps.size())}});
      const auto found = decode_program(*map.memory, {20}, paper.read(), one_decimal);
      ASSERT_TRUE(found) << name << ": " << text(found.error());
      ASSERT_EQ(found->steps.size(), program.steps.size()) << name << ", seed 3, " << round;
      for (std::size_t i = 0; i < program.steps.size(); ++i) {
        EXPECT_NEAR(found->steps[i].target.value, program.steps[i].target.value, 0.051) << name << " step " << i;
        EXPECT_EQ(found->steps[i].duration, program.steps[i].duration) << name << " step " << i;
        EXPECT_EQ(found->steps[i].kind, program.steps[i].kind) << name << " step " << i;
      }
    }
  }
}

TEST(ProgramMemory, SplitsLongStep) {
  const auto map = shipped("watlow_f4t");
  const ChamberProgram program{
      .name = "LONG", .number = 1, .soak_band = {}, .steps = {{StepKind::ramp, {20}, {50}, hours(250), false}}};
  const auto steps = steps_in_memory(*map.memory, program);
  ASSERT_TRUE(steps);
  ASSERT_EQ(steps->size(), 4u) << "three parts and the end";
  Duration whole{};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LE((*steps)[i].duration, map.memory->longest_step);
    EXPECT_NEAR(((*steps)[i].target - (*steps)[i].start).value / to_seconds((*steps)[i].duration), 30.0 / 900000, 1e-9);
    whole += (*steps)[i].duration;
  }
  EXPECT_EQ(whole, hours(250));
  EXPECT_EQ((*steps)[2].target, Celsius{50});
}

TEST(ProgramMemory, PartsAreNotLongerThanLongestStepThatIsNoMultiple) {
  auto memory = *shipped("watlow_f4t").memory;
  memory.finest = minutes(1);
  int programs = 0;
  for (const auto longest : {seconds(599), seconds(90), seconds(119), seconds(61), seconds(600)})
    for (const auto whole : {minutes(1), minutes(10), minutes(19), minutes(29)}) {
      memory.longest_step = longest;
      memory.steps_at_most = 40;
      const ChamberProgram program{
          .name = "P", .number = 1, .soak_band = {}, .steps = {{StepKind::ramp, {20}, {50}, whole, false}}};
      const auto steps = steps_in_memory(memory, program);
      ASSERT_TRUE(steps) << text(steps.error());
      Duration sum{};
      for (const auto& step : *steps) {
        if (step.kind == StepKind::end) continue;
        EXPECT_LE(step.duration, Duration(longest));
        EXPECT_GT(step.duration, Duration{});
        EXPECT_EQ(step.duration % Duration(minutes(1)), Duration{});
        sum += step.duration;
      }
      EXPECT_EQ(sum, Duration(whole));
      ++programs;
    }
  EXPECT_EQ(programs, 20);
}

const std::string kMapWithRates = std::string(kTwoRegisters) + R"([profile_memory]
steps_at_most = 9
longest_step = "10 h"
end_step = true
ramps_by = "rate"
stride = 10
[[profile_memory.step]]
address = 1000
cell = [
  { holds = "target", type = "s16" },
  { at = 1, holds = "rate", type = "TYPE", scale = 0.1, order = "abcd" },
  { at = 5, holds = "total_seconds", type = "u32" },
]
)";

TEST(ProgramMemory, EndStepWithoutTimeHasRateZero) {
  for (const std::string type : {"u16", "f32", "f64"}) {
    std::string file = kMapWithRates;
    file.replace(file.find("TYPE"), 4, type);
    const auto map = parse_register_map(file, "map.toml");
    ASSERT_TRUE(map) << text(map.error());
    const ChamberProgram program{
        .name = "P", .number = 1, .soak_band = {}, .steps = {{StepKind::ramp, {20}, {50}, minutes(10), false}}};
    const auto writes = encode_program(*map->memory, program, {});
    ASSERT_TRUE(writes) << type << ": " << text(writes.error());
    ASSERT_EQ(writes->size(), 2u);
    const auto& rate = map->memory->step.at(0).cells.at(1);
    const auto found = [&](std::size_t step) {
      return decode_as_written(rate.form, std::span(writes->at(step).words).subspan(rate.at, word_count(rate.form)));
    };
    EXPECT_NEAR(found(0), 3, 1e-6) << type;
    EXPECT_EQ(found(1), 0) << type;
  }
}

TEST(ProgramMemory, RefusesProgramThatDoesNotFit) {
  const auto ezt = shipped("csz_ezt570i"), binder = shipped("binder_mb2");
  const auto program = [](std::size_t steps, Duration time, bool guaranteed) {
    return ChamberProgram{.name = "P",
                          .number = 1,
                          .soak_band = {},
                          .steps = std::vector<ProgramStep>(steps, {StepKind::soak, {20}, {20}, time, guaranteed})};
  };
  EXPECT_TRUE(encode_program(*ezt.memory, program(99, seconds(1), true)));
  const auto many = encode_program(*ezt.memory, program(100, seconds(1), true));
  ASSERT_FALSE(many);
  EXPECT_NE(many.error().what.find("stores 99 steps, and the program needs 100"), std::string::npos)
      << many.error().what;
  EXPECT_EQ(encode_program(*ezt.memory, program(1, std::chrono::milliseconds(1500), false)).error().kind,
            FaultKind::out_of_range);
  EXPECT_NE(encode_program(*binder.memory, program(1, seconds(1), true)).error().what.find("no guaranteed soak"),
            std::string::npos);
  EXPECT_FALSE(encode_program(*ezt.memory, program(0, seconds(1), false)));
  ChamberProgram hot = program(1, seconds(1), false);
  hot.steps[0].target = {4000};
  EXPECT_FALSE(encode_program(*ezt.memory, hot));
}

}  // namespace
}  // namespace gyrotherm::drivers
