// SPDX-License-Identifier: Apache-2.0
/// Proof tests of chambers on a serial line, which only one program can open at a time. The line is a pseudo-terminal.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "sequencer/watchdog/safe_state_file.hpp"
#include "tests/sequencer/prove/prove_bench.hpp"
#include "tests/support/folder.hpp"

namespace gyrotherm::prove {
namespace {

struct SerialCase {
  const char* map;
  drivers::LinkKind link;
};

/// Returns the virtual rig with another chamber. The map with the limiter gets a serial link; its copy is in `folder`.
rig::RigFile read_serial_rig(const SerialCase& serial, const tests::TestFolder& folder) {
  auto path = std::string(GYROTHERM_SOURCE_DIR "/profiles/chambers/") + serial.map + ".toml";
  if (serial.map == std::string("virtual_limiter")) {
    auto map_text = read_text_file(path).value();
    const std::string port = "port = 5020\n";
    map_text.erase(map_text.find(port), port.size());
    map_text.insert(map_text.find("[[register]]"), "[link.tcp]\n" + port + "[link.rtu]\nserial = \"9600,8N1\"\n\n");
    path = folder / "map.toml";
    std::ofstream(path) << map_text;
  }
  return read_rig_with_map(path);
}

class SerialProof : public ::testing::TestWithParam<SerialCase> {
 protected:
  const tests::TestFolder folder;
  const std::string record = folder / "child.db";
  ProveBench bench{read_serial_rig(GetParam(), folder), true, GetParam().link};
};

TEST_P(SerialProof, TakesSnapshotAndRestoresItOnOneConnection) {
  const auto before = bench.registers();
  {
    const auto [registers, chamber] = connect_with_registers(bench.rig);
    EXPECT_TRUE(chamber->identify());
    const auto found = ChamberSnapshot::take(bench.rig.chamber_map, *registers, *chamber).value();
    ASSERT_TRUE(chamber->send_set_point({31}));
    ASSERT_TRUE(chamber->start());
    const auto restored = found.restore(*registers, *chamber);
    EXPECT_TRUE(restored) << text(restored.error());
    EXPECT_FALSE(connect_chamber(bench.rig)->inspect()) << "the line is exclusive while it is open";
  }
  EXPECT_EQ(bench.registers(), before);
}

TEST_P(SerialProof, PassesMakeSafe) {
  const auto result = prove_make_safe(bench.rig, record, bench.environment());
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
  EXPECT_LE(abs(bench.chamber().set_point - bench.rig.safe_set_point), set_point_tolerance(bench.rig.chamber_map));
  const auto trace = watchdog::read_trace(record);
  ASSERT_TRUE(trace && *trace);
  EXPECT_TRUE((*trace)->confirmed);
}

TEST_P(SerialProof, FailsWhenLineIsHeldByAnotherProgram) {
  const auto held = connect_chamber(bench.rig);
  ASSERT_TRUE(held->inspect());
  const auto result = prove_make_safe(bench.rig, record, bench.environment());
  EXPECT_EQ(result.verdict, ProofVerdict::failed);
  EXPECT_NE(result.cause.find("in use by another program"), std::string::npos) << result.cause;
}

TEST_P(SerialProof, DoesNotCutLine) {
  EXPECT_EQ(prove_line(bench.rig, record, bench.environment()).verdict, ProofVerdict::not_tested);
}

INSTANTIATE_TEST_SUITE_P(Maps, SerialProof,
                         ::testing::Values(SerialCase{"virtual_limiter", drivers::LinkKind::rtu},
                                           SerialCase{"watlow_f4", drivers::LinkKind::rtu},
                                           SerialCase{"thermotron_3800", drivers::LinkKind::text_serial}),
                         [](const auto& one) { return std::string(one.param.map); });

/// The trace of the guard is the only evidence on a line that only the guard can use.
TEST(SerialUnreadableSetPoint, PassesMakeSafe) {
  const tests::TestFolder folder;
  ProveBench bench(read_serial_rig({"tt5166", drivers::LinkKind::rtu}, folder), true, drivers::LinkKind::rtu);
  const auto result = prove_make_safe(bench.rig, folder / "child.db", bench.environment());
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
  EXPECT_TRUE(std::isnan(bench.chamber().set_point.value));
}

TEST(SerialLimiter, PassesWhenLimiterTrips) {
  const tests::TestFolder folder;
  ProveBench bench(read_serial_rig({"virtual_limiter", drivers::LinkKind::rtu}, folder), false, drivers::LinkKind::rtu);
  const auto plan = plan_limiter_proof(bench.rig, bench.chamber().air).value();
  const auto result = prove_limiter(plan, bench.guarded(), bench.environment());
  EXPECT_EQ(result.verdict, ProofVerdict::passed) << result.cause;
}

}  // namespace
}  // namespace gyrotherm::prove
