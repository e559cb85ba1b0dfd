// SPDX-License-Identifier: Apache-2.0
#include "simulator/virtual_instruments.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <deque>
#include <span>
#include <string>
#include <string_view>

#include "drivers/line/modbus_frame.hpp"
#include "tests/simulator/loopback_client.hpp"
#include "tests/simulator/shipped_rigs.hpp"
#include "tests/support/modbus_words.hpp"

namespace gyrotherm::simulator {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

/// Returns the received bytes of a line.
std::string received_on(drivers::ByteStream& line) {
  std::array<std::byte, 4096> buffer{};
  const auto size = line.read(buffer, {});
  return {reinterpret_cast<const char*>(buffer.data()), size.value_or(0)};
}

class VirtualInstrumentsTest : public testing::Test {
 protected:
  static std::unique_ptr<VirtualInstruments> start(std::uint64_t seed = 0) {
    auto started = VirtualInstruments::start(VirtualLaboratory(laboratory_of_rig("virtual"), {.gyro = seed, .run = 0}),
                                             {.chamber = chamber_map("virtual"),
                                              .thermometers = {{{"A", "B", "C", "D", "E", "F", "G", "H"}}, {{"shell"}}},
                                              .gyros = {{.frame = gyro_of_rig("virtual")}}});
    EXPECT_TRUE(started) << text(started.error());
    return std::move(*started);
  }
  [[nodiscard]] double read_chamber(const Client& client, const char* item) const {
    const auto& found = *map.find(item);
    const drivers::ModbusRequest request{
        1, map.link.modbus.unit, drivers::ModbusFunction::read_holding, found.address, word_count(found.type), {}};
    client.send(encode_request(request));
    const auto words = decode_reply(request, client.receive(9 + 2 * std::size_t{request.count}));
    EXPECT_TRUE(words);
    return words ? *decode(found, *words) : 0;
  }
  void write_chamber(const Client& client, const char* item, double value) const {
    const auto& found = *map.find(item);
    const auto words = encode(found, value);
    const drivers::ModbusRequest request{2,
                                         map.link.modbus.unit,
                                         drivers::ModbusFunction::write_multiple,
                                         found.address,
                                         static_cast<std::uint16_t>(words.size()),
                                         words};
    client.send(encode_request(request));
    EXPECT_TRUE(decode_reply(request, client.receive(12)));
  }
  static std::string ask(const Client& client, const char* command) {
    client.send(command);
    return client.receive_line();
  }

  drivers::RegisterMap map = chamber_map("virtual");
  std::unique_ptr<VirtualInstruments> instruments = start();
};

TEST_F(VirtualInstrumentsTest, ShowNewStateAfterTimeAdvances) {
  const Client chamber(instruments->chamber_port());
  const Client thermometer(instruments->thermometer_port(0));
  VirtualLaboratory same(laboratory_of_rig("virtual"), {});
  write_chamber(chamber, "set_point", -30);
  write_chamber(chamber, "control_mode", 1);
  same.change_set_point({-30});
  same.switch_on(true);
  for (int i = 0; i < 50; ++i) {
    instruments->advance(7);
    for (int t = 0; t < 7; ++t) same.step();
    ASSERT_NEAR(read_chamber(chamber, "air_temperature"), same.air_as_measured().value, 1e-5);
    ASSERT_NEAR(std::stod(ask(thermometer, "CRDG? 2\r\n")), same.thermometers_as_measured_c()[1], 0.0005);
  }
}

TEST_F(VirtualInstrumentsTest, ServeChannelsOfEachThermometer) {
  const Client shell(instruments->thermometer_port(1));
  const VirtualLaboratory same(laboratory_of_rig("virtual"), {});
  EXPECT_NEAR(std::stod(ask(shell, "CRDG? 1\r\n")), same.thermometers_as_measured_c()[8], 0.0005);
}

TEST_F(VirtualInstrumentsTest, AnswerOnCallingThreadWhenAttended) {
  const auto attended =
      VirtualInstruments::start(VirtualLaboratory(laboratory_of_rig("virtual"), {}),
                                {.chamber = map,
                                 .thermometers = {{{"A", "B", "C", "D", "E", "F", "G", "H"}}, {{"shell"}}},
                                 .gyros = {{.frame = gyro_of_rig("virtual")}},
                                 .attended = true})
          .value();
  EXPECT_TRUE(attended->lines().empty()) << "no other client can connect";
  EXPECT_EQ(attended->chamber_port(), 0);
  const auto gyro = attended->line(InstrumentKind::gyro);
  const auto shell = attended->line(InstrumentKind::thermometer, 1);
  const VirtualLaboratory same(laboratory_of_rig("virtual"), {});
  EXPECT_EQ(received_on(*shell), "") << "no request was sent";
  ASSERT_TRUE(shell->write(bytes_of("CRDG? 1\r\n"), {}));
  EXPECT_NEAR(std::stod(received_on(*shell)), same.thermometers_as_measured_c()[8], 0.0005);
  EXPECT_EQ(received_on(*gyro), "") << "frames are sent only when time advances";
  attended->advance(1);
  EXPECT_EQ(received_on(*gyro).size(), 16U) << "a frame";
}

TEST_F(VirtualInstrumentsTest, CloseGyroLineWithoutReaderAndSendOnNewOne) {
  const auto attended =
      VirtualInstruments::start(
          VirtualLaboratory(laboratory_of_rig("virtual"), {}),
          {.chamber = map, .thermometers = {}, .gyros = {{.frame = gyro_of_rig("virtual")}}, .attended = true})
          .value();
  const auto gyro = attended->line(InstrumentKind::gyro);
  EXPECT_EQ(received_on(*gyro), "");
  attended->advance(static_cast<int>(MemoryPipe::kCapacity / 16 + 100));
  std::size_t heard = 0;
  while (const auto size = received_on(*gyro).size()) heard += size;
  EXPECT_EQ(heard, MemoryPipe::kCapacity) << "as many whole frames as fit";
  attended->advance(1);
  EXPECT_EQ(received_on(*gyro), "") << "the line was closed and opened again";
  attended->advance(1);
  EXPECT_EQ(received_on(*gyro).size(), 16U);
}

TEST_F(VirtualInstrumentsTest, AnswerForChamberOnLineWhenAttended) {
  const auto attended = VirtualInstruments::start(VirtualLaboratory(laboratory_of_rig("virtual"), {}),
                                                  {.chamber = map, .thermometers = {}, .gyros = {}, .attended = true})
                            .value();
  const auto chamber = attended->line(InstrumentKind::chamber);
  const auto& found = *map.find("air_temperature");
  const drivers::ModbusRequest request{
      1, map.link.modbus.unit, drivers::ModbusFunction::read_holding, found.address, word_count(found.type), {}};
  const auto question = encode_request(request);
  std::array<std::byte, 260> answer{};
  for (const std::byte byte : question) {
    EXPECT_FALSE(chamber->read(answer, {})) << "not yet";
    ASSERT_TRUE(chamber->write(std::span(&byte, 1), {}));
  }
  const auto size = chamber->read(answer, {});
  ASSERT_TRUE(size);
  EXPECT_TRUE(decode_answer(request, std::span(answer).first(*size)));
}

TEST_F(VirtualInstrumentsTest, SendOneFramePerSecondToEveryGyroClient) {
  const Client first(instruments->gyro_port());
  const Client second(instruments->gyro_port());
  instruments->advance(10);
  const auto bytes = first.receive(160);
  EXPECT_EQ(bytes, second.receive(160));
  drivers::FrameDecoder decoder(gyro_of_rig("virtual"));
  decoder.feed(bytes);
  VirtualLaboratory same(laboratory_of_rig("virtual"), {});
  for (std::uint32_t i = 0; i < 10; ++i) {
    const auto* frame = decoder.take();
    same.step();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->axes[0].pulses, same.pulses()[0]);
    EXPECT_EQ(frame->sequence, i);
    EXPECT_EQ(frame->timestamp, static_cast<std::uint64_t>(same.device_time_us()));
  }
  EXPECT_EQ(decoder.rejected_bytes(), 0U);
}

TEST_F(VirtualInstrumentsTest, ReplayReachesSameState) {
  const auto replayed = start(5);
  instruments = start(5);
  std::vector<PastSecond> past;
  {
    const Client chamber(instruments->chamber_port());
    write_chamber(chamber, "control_mode", 1);
    for (int i = 0; i < 300; ++i) {
      write_chamber(chamber, "set_point", 20 - 0.1 * i);
      past.push_back({{read_chamber(chamber, "set_point")}});
      instruments->advance(1);
    }
  }
  replayed->replay(past);
  std::array<std::vector<std::byte>, 2> frames;
  std::array<std::string, 2> readings;
  std::array<double, 2> air_c{};
  const std::array<VirtualInstruments*, 2> both{instruments.get(), replayed.get()};
  for (std::size_t i = 0; i < 2; ++i) {
    const Client gyro(both[i]->gyro_port());
    both[i]->advance(5);
    frames[i] = gyro.receive(80);
    readings[i] = ask(Client(both[i]->thermometer_port(0)), "CRDG? 0\r\n");
    air_c[i] = read_chamber(Client(both[i]->chamber_port()), "air_temperature");
  }
  EXPECT_EQ(frames[0], frames[1]);
  EXPECT_EQ(frames[0].size(), 80U);
  EXPECT_EQ(readings[0], readings[1]);
  EXPECT_EQ(air_c[0], air_c[1]);
}

TEST_F(VirtualInstrumentsTest, SurviveInvalidClients) {
  const Client well_behaved(instruments->chamber_port());
  for (int i = 0; i < 100; ++i) {
    const Client rude(instruments->chamber_port());
    rude.send("\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff");
    const Client hasty(instruments->thermometer_port(0));
    hasty.send("CRDG? 0\r\nCRD");
    const Client leaver(instruments->gyro_port());
    instruments->advance(1);
  }
  EXPECT_EQ(read_chamber(well_behaved, "set_point"), 20);
}

TEST_F(VirtualInstrumentsTest, DropClientThatViolatesProtocol) {
  const Client rude(instruments->chamber_port());
  rude.send("\x00\x01\x00\x63 no modbus");
  rude.send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(rude.was_dropped());
}

TEST_F(VirtualInstrumentsTest, AdmitAtMostSixteenClients) {
  std::deque<Client> clients;
  for (int i = 0; i < 16; ++i) {
    clients.emplace_back(instruments->thermometer_port(0));
    EXPECT_FALSE(ask(clients.back(), "*IDN?\r\n").empty());
  }
  const Client seventeenth(instruments->thermometer_port(0));
  EXPECT_TRUE(seventeenth.was_dropped());
  clients.pop_front();
  EXPECT_FALSE(ask(clients.back(), "*IDN?\r\n").empty());
}

TEST_F(VirtualInstrumentsTest, DropClientThatDoesNotReadReplies) {
  const Client greedy(instruments->thermometer_port(0));
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "CRDG? 0\r\n";
  int sent = 0;
  while (sent < 10000 && greedy.send(many)) ++sent;
  EXPECT_LT(sent, 10000);
  const Client patient(instruments->thermometer_port(0));
  EXPECT_FALSE(ask(patient, "*IDN?\r\n").empty());
}

TEST_F(VirtualInstrumentsTest, RefuseUnknownChannel) {
  const auto started = VirtualInstruments::start(
      VirtualLaboratory(laboratory_of_rig("virtual"), {}),
      {.chamber = map, .thermometers = {{{"A", "Z"}}}, .gyros = {{.frame = gyro_of_rig("virtual")}}});
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().kind, FaultKind::bad_file);
  EXPECT_NE(started.error().what.find("\"Z\""), std::string::npos);
}

TEST_F(VirtualInstrumentsTest, ReportUsedPort) {
  const auto started = VirtualInstruments::start(VirtualLaboratory(laboratory_of_rig("virtual"), {}),
                                                 {.chamber = map,
                                                  .thermometers = {},
                                                  .gyros = {{.frame = gyro_of_rig("virtual")}},
                                                  .first_port = instruments->chamber_port()});
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().kind, FaultKind::disconnected);
  EXPECT_NE(started.error().where.find(std::to_string(instruments->chamber_port())), std::string::npos);
}

}  // namespace
}  // namespace gyrotherm::simulator
