// SPDX-License-Identifier: Apache-2.0
/// Tests the gyro lines of a chamber with many units: their content, frame rate and silence.
#include "simulator/virtual_gyro_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "simulator/virtual_instruments.hpp"
#include "tests/simulator/loopback_client.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/simulator/small_gyro.hpp"

namespace gyrotherm::simulator {
namespace {

/// Size of a frame of pulse-count-xyz.
constexpr std::size_t kFrameBytes = 28;

/// Returns the laboratory of a shipped rig with small bodies.
LaboratoryParameters small_rig(const std::string& rig) {
  auto world = laboratory_of_rig(rig);
  auto& body = std::get<ReducedGyroParameters>(world.body);
  body.model = small_gyro();
  body.arms = {};
  return world;
}

std::unique_ptr<VirtualInstruments> serve(const LaboratoryParameters& world, std::vector<VirtualGyroLine> gyros,
                                          FramePace pace = {}, LaboratorySeed seed = {}) {
  auto started = VirtualInstruments::start(
      VirtualLaboratory(world, seed),
      {.chamber = chamber_map("virtual"), .thermometers = {}, .gyros = std::move(gyros), .frames = pace});
  EXPECT_TRUE(started) << text(started.error());
  return std::move(*started);
}

/// Returns a line of the lot that sends these axes, which belong to several units.
VirtualGyroLine shared_line(std::vector<VirtualGyroLine::Axis> axes) {
  auto line = gyro_lines_of_rig("virtual-lot").front();
  line.axes = std::move(axes);
  return line;
}

std::vector<drivers::GyroFrame> frames_in(const VirtualGyroLine& line, const std::vector<std::byte>& bytes) {
  drivers::FrameDecoder decoder(line.frame);
  decoder.feed(bytes);
  std::vector<drivers::GyroFrame> frames;
  while (const auto* frame = decoder.take()) frames.push_back(*frame);
  EXPECT_EQ(decoder.rejected_bytes(), 0U);
  return frames;
}

TEST(VirtualGyroLine, ExistsForEachUnitOfLot) {
  const auto world = small_rig("virtual-lot");
  const auto lines = gyro_lines_of_rig("virtual-lot");
  const auto instruments = serve(world, lines);
  VirtualLaboratory same(world, {});
  std::vector<std::unique_ptr<Client>> clients;
  for (std::size_t i = 0; i < lines.size(); ++i) clients.push_back(std::make_unique<Client>(instruments->gyro_port(i)));
  instruments->advance(3);
  for (int t = 0; t < 3; ++t) {
    same.step();
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const auto frames = frames_in(lines[i], clients[i]->receive(kFrameBytes));
      ASSERT_EQ(frames.size(), 1U);
      for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(frames[0].axes[a].pulses, same.pulses(i)[a]) << i << t << a;
      EXPECT_EQ(frames[0].timestamp, static_cast<std::uint64_t>(same.device_time_us(i)));
      EXPECT_NEAR(frames[0].values[0].value(), same.values(i)[0].value, 0.006) << "self";
      EXPECT_NEAR(frames[0].values[1].value(), same.values(i)[1].value, 1e-7) << "discharge_current_a";
    }
  }
}

TEST(VirtualGyroLine, IsNamedAfterUnits) {
  const auto world = small_rig("virtual-lot");
  const auto names = [&](std::vector<VirtualGyroLine> lines) {
    std::vector<std::string> found;
    for (const auto& line : serve(world, std::move(lines))->lines())
      if (line.instrument.starts_with("gyro")) found.push_back(line.instrument);
    return found;
  };
  const auto shared = shared_line({{"u1", "x"}, {"u3", "y"}, {"u1", "z"}});
  EXPECT_EQ(names({shared}), std::vector<std::string>{"gyro"});
  EXPECT_EQ(names({shared, gyro_lines_of_rig("virtual-lot")[1]}), (std::vector<std::string>{"gyro u1+u3", "gyro u2"}));
}

TEST(VirtualGyroLine, CarriesAxesOfSeveralUnits) {
  const auto world = small_rig("virtual-lot");
  auto line = shared_line({{"u2", "z"}, {"u1", "x"}, {"u8", "y"}});
  const auto instruments = serve(world, {line});
  const Client client(instruments->gyro_port());
  VirtualLaboratory same(world, {});
  instruments->advance(20);
  for (int t = 0; t < 20; ++t) same.step();
  const auto frames = frames_in(line, client.receive(20 * kFrameBytes));
  ASSERT_EQ(frames.size(), 20U);
  EXPECT_EQ(frames.back().axes[0].pulses, same.pulses(1)[2]);
  EXPECT_EQ(frames.back().axes[1].pulses, same.pulses(0)[0]);
  EXPECT_EQ(frames.back().axes[2].pulses, same.pulses(7)[1]);
  EXPECT_NEAR(frames.back().values[0].value(), same.values(1)[0].value, 0.006) << "value of the first unit";
}

TEST(VirtualGyroLine, FindsValueByUnitName) {
  const auto world = small_rig("virtual-lot");
  auto line = shared_line({{"u2", "z"}, {"u1", "x"}, {"u8", "y"}});
  for (auto& field : line.frame.fields)
    if (field.name == "self") field.name = "u8_self";
  const auto instruments = serve(world, {line});
  const Client client(instruments->gyro_port());
  VirtualLaboratory same(world, {});
  same.step();
  instruments->advance(1);
  EXPECT_NEAR(frames_in(line, client.receive(kFrameBytes)).at(0).values[0].value(), same.values(7)[0].value, 0.006);
}

TEST(VirtualGyroLine, RefusesUnknownAxesAndWrongCount) {
  const VirtualLaboratory laboratory(small_rig("virtual-lot"), {});
  const auto mistake = [&](std::vector<VirtualGyroLine::Axis> axes) {
    const auto sources = find_sources(shared_line(std::move(axes)), laboratory);
    EXPECT_FALSE(sources);
    EXPECT_EQ(sources.error().kind, FaultKind::usage);
    return sources.error().what;
  };
  EXPECT_NE(mistake({{"u9", "x"}, {"u1", "x"}, {"u1", "y"}}).find("\"u9\""), std::string::npos);
  EXPECT_NE(mistake({{"u1", "x"}, {"u1", "w"}, {"u1", "y"}}).find("\"w\""), std::string::npos);
  EXPECT_NE(mistake({{"u1", "x"}}).find("1 axes"), std::string::npos);
  EXPECT_NE(mistake({}).find("0 axes"), std::string::npos) << "ambiguous with several units";
}

/// Lines with different frame rates have only the last frame of a second in common.
TEST(VirtualGyroLine, HasOwnFrameRate) {
  const auto world = small_rig("virtual-lot");
  auto lines = gyro_lines_of_rig("virtual-lot");
  lines.resize(2);
  lines[0].frame.rate_hz = 7;
  lines[1].frame.rate_hz = 100;
  const auto instruments = serve(world, lines, FramePace::full_rate);
  const Client slow(instruments->gyro_port(0)), fast(instruments->gyro_port(1));
  VirtualLaboratory same(world, {});
  for (int t = 0; t < 3; ++t) {
    for (int ms = 0; ms < 1000; ++ms) instruments->pass(std::chrono::milliseconds(1));
    same.step();
    const auto of_slow = frames_in(lines[0], slow.receive(7 * kFrameBytes));
    const auto of_fast = frames_in(lines[1], fast.receive(100 * kFrameBytes));
    ASSERT_EQ(of_slow.size(), 7U);
    ASSERT_EQ(of_fast.size(), 100U);
    EXPECT_EQ(of_slow.back().axes[0].pulses, same.pulses(0)[0]) << "the frames of a second sum to its angle";
    EXPECT_EQ(of_fast.back().axes[2].pulses, same.pulses(1)[2]);
    EXPECT_TRUE(std::ranges::is_sorted(of_fast, {}, [](const auto& frame) { return *frame.timestamp; }));
  }
}

TEST(VirtualGyroLine, IsNotNeededToAdvance) {
  const auto world = small_rig("virtual-triad");
  const auto instruments = serve(world, {});
  VirtualLaboratory same(world, {});
  for (int ms = 0; ms < 2500; ++ms) instruments->pass(std::chrono::milliseconds(1));
  for (int t = 0; t < 2; ++t) same.step();
  for (std::size_t unit = 0; unit < 3; ++unit)
    EXPECT_EQ(instruments->true_bias(unit), std::vector(same.true_bias(unit).begin(), same.true_bias(unit).end()));
}

/// Frames of the silent unit are lost, but its counts continue. The line of its neighbour is unchanged.
TEST(VirtualGyroLine, SendsNothingForSilentUnit) {
  const auto world = small_rig("virtual-triad");
  const auto lines = gyro_lines_of_rig("virtual-triad");
  const auto instruments = serve(world, lines);
  const Client x(instruments->gyro_port(0)), y(instruments->gyro_port(1));
  VirtualLaboratory same(world, {});
  instruments->advance(2);
  instruments->silence(0, true);
  instruments->advance(3);
  instruments->silence(0, false);
  instruments->advance(1);
  for (int t = 0; t < 6; ++t) same.step();
  const auto of_x = frames_in(lines[0], x.receive(3 * 16));
  const auto of_y = frames_in(lines[1], y.receive(6 * 16));
  ASSERT_EQ(of_x.size(), 3U);
  ASSERT_EQ(of_y.size(), 6U);
  EXPECT_EQ(of_x[2].sequence, 5U) << "three frames were lost";
  EXPECT_EQ(of_x[2].axes[0].pulses, same.pulses(0)[0]);
  EXPECT_EQ(of_y[5].axes[0].pulses, same.pulses(1)[0]);
}

TEST(VirtualGyroLine, FreezesCountsOfSilentUnit) {
  const auto world = small_rig("virtual-lot");
  const auto line = shared_line({{"u1", "x"}, {"u2", "x"}, {"u1", "y"}});
  const auto instruments = serve(world, {line});
  const Client client(instruments->gyro_port());
  VirtualLaboratory same(world, {});
  std::int64_t lost = 0;
  const auto pass = [&] {
    const auto before = same.pulses(1)[0];
    instruments->advance(1);
    same.step();
    if (same.is_silent(1)) lost += same.pulses(1)[0] - before;
    const auto frame = frames_in(line, client.receive(kFrameBytes)).at(0);
    EXPECT_EQ(frame.axes[0].pulses, same.pulses(0)[0]);
    EXPECT_EQ(frame.axes[1].pulses, same.pulses(1)[0] - lost);
    EXPECT_EQ(frame.axes[2].pulses, same.pulses(0)[1]);
  };
  for (const bool silent : {false, true, false}) {
    instruments->silence(1, silent);
    same.silence(1, silent);
    for (int t = 0; t < 5; ++t) pass();
  }
  EXPECT_GT(lost, 0);
}

TEST(VirtualGyroLine, ReplayReachesSameState) {
  const auto world = small_rig("virtual-triad");
  const auto lines = gyro_lines_of_rig("virtual-triad");
  const std::vector<PastSecond> past(100, PastSecond{{5}});
  const auto lived = serve(world, lines, {}, {.gyro = 4}), again = serve(world, lines, {}, {.gyro = 4});
  lived->replay(past);
  again->replay(std::span(past).first(60));
  again->replay(std::span(past).last(40));
  for (std::size_t i = 0; i < 3; ++i) {
    const Client one(lived->gyro_port(i)), other(again->gyro_port(i));
    for (const auto* instruments : {&lived, &again}) (*instruments)->advance(1);
    EXPECT_EQ(one.receive(16), other.receive(16));
    EXPECT_EQ(lived->true_bias(i), again->true_bias(i));
  }
}

}  // namespace
}  // namespace gyrotherm::simulator
