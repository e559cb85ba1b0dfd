// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "core/deadline.hpp"
#include "core/file.hpp"
#include "drivers/line/modbus.hpp"
#include "drivers/line/modbus_frame.hpp"
#include "tests/drivers/line/words.hpp"
#include "tests/support/loopback_server.hpp"

namespace gyrotherm::drivers {
namespace {

using std::chrono::milliseconds;
constexpr Duration kTimeout = milliseconds(60);
constexpr auto kHolding = ReadFunction::holding_registers;

std::unique_ptr<Registers> make_client(const TcpLine& line) {
  ModbusLink link;
  link.timeout = kTimeout;
  return make_modbus(line, link);
}

Words words_of(const ModbusRequest& request) {
  Words words(request.count);
  for (std::uint16_t i = 0; i < request.count; ++i) words[i] = static_cast<std::uint16_t>(request.address + i);
  return words;
}

/// Returns the correct answer: each register holds its own address.
std::vector<std::byte> good(const ModbusRequest& request) {
  return encode_reply(request, request.words.empty() ? words_of(request) : Words{});
}

/// A server that answers its n-th request (from 0) as `behaviour` returns.
class Unit {
 public:
  using Behaviour = std::function<Answer(int number, const ModbusRequest& request, std::span<const std::byte> frame)>;
  explicit Unit(Behaviour behaviour)
      : behaviour_(std::move(behaviour)), server_([this](std::span<const std::byte> frame) {
          const auto request = decode_request(frame);
          return request ? behaviour_(number_++, *request, frame) : Answer{};
        }) {}

  [[nodiscard]] std::unique_ptr<Registers> client() const { return make_client(server_.address()); }
  [[nodiscard]] int connections() const { return server_.connections(); }
  [[nodiscard]] int requests() const { return server_.requests(); }

 private:
  Behaviour behaviour_;
  int number_ = 0;
  LoopbackServer server_;
};

TEST(ModbusTcp, ReadsAndWritesOnOneConnection) {
  Unit unit([](int, const auto& request, auto) { return Answer{good(request)}; });
  const auto client = unit.client();
  EXPECT_EQ(client->read(kHolding, 2782, 2).value(), (Words{2782, 2783}));
  EXPECT_TRUE(client->write(WriteFunction::registers, 2782, Words{0xC221, 0}));
  EXPECT_TRUE(client->write(WriteFunction::one_register, 2782, Words{7}));
  EXPECT_EQ(client->read(kHolding, 0, 125).value().size(), 125u);
  EXPECT_EQ(unit.connections(), 1);
  EXPECT_EQ(unit.requests(), 4);
}

/// Opens files until descriptor numbers exceed the limit of select().
class ManyOpenFiles {
 public:
  ManyOpenFiles() {
    ::getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit more{std::max<rlim_t>(before_.rlim_cur, 2048), before_.rlim_max};
    works_ = ::setrlimit(RLIMIT_NOFILE, &more) == 0;
    while (works_ && (open_.empty() || open_.back().number() < 1030)) {
      open_.emplace_back(::open("/dev/null", O_RDONLY | O_CLOEXEC));
      works_ = open_.back().is_open();
    }
  }
  ~ManyOpenFiles() {
    open_.clear();
    ::setrlimit(RLIMIT_NOFILE, &before_);
  }
  ManyOpenFiles(const ManyOpenFiles&) = delete;
  ManyOpenFiles& operator=(const ManyOpenFiles&) = delete;
  [[nodiscard]] bool works() const { return works_; }

 private:
  rlimit before_{};
  std::vector<Descriptor> open_;
  bool works_{};
};

TEST(ModbusTcp, TooManyOpenFilesAreAFault) {
  Unit unit([](int, const auto& request, auto) { return Answer{good(request)}; });
  const auto client = unit.client();
  {
    const ManyOpenFiles many;
    if (!many.works()) GTEST_SKIP() << "so many files may not be opened here";
    const auto read = client->read(kHolding, 1, 1);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().kind, FaultKind::disconnected);
    EXPECT_NE(read.error().what.find("more than 1000 files are open, expected fewer"), std::string::npos)
        << read.error().what;
  }
  EXPECT_TRUE(client->read(kHolding, 1, 1)) << "and it passes";
}

TEST(ModbusTcp, NoTransactionIsUsedTwiceAlsoAcrossConnections) {
  std::vector<std::uint16_t> seen;
  Unit unit([&](int number, const auto& request, auto) {
    seen.push_back(request.transaction);
    return Answer{good(request), number % 2 == 1};
  });
  const auto client = unit.client();
  for (int i = 0; i < 6; ++i) (void)client->read(kHolding, 1, 1);
  for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_GT(seen[i], seen[i - 1]);
  EXPECT_GT(unit.connections(), 2);
}

TEST(ModbusTcp, ReconnectsAndRetriesAfterCorruptedReply) {
  Unit unit([](int number, const auto& request, auto) {
    auto reply = good(request);
    if (number == 1) reply[6] = std::byte{9};
    return Answer{reply};
  });
  const auto client = unit.client();
  EXPECT_TRUE(client->read(kHolding, 5, 1));
  EXPECT_EQ(client->read(kHolding, 6, 1).value(), Words{6});
  EXPECT_EQ(unit.connections(), 2);
}

TEST(ModbusTcp, NeverAcceptsLateReplyForNextRequest) {
  std::vector<std::byte> late;
  Unit unit([&](int number, const auto& request, auto) {
    if (number == 0) return late = good(request), Answer{};
    auto both = std::exchange(late, {});
    const auto own = good(request);
    both.insert(both.end(), own.begin(), own.end());
    return Answer{both};
  });
  const auto client = unit.client();
  EXPECT_EQ(client->read(kHolding, 60, 1).value(), Words{60});
  EXPECT_EQ(client->read(kHolding, 61, 1).value(), Words{61});
  EXPECT_EQ(client->read(kHolding, 62, 1).value(), Words{62});
}

TEST(ModbusTcp, TimesOutWithinLimitWhenUnitIsSilent) {
  Unit unit([](int, const auto&, auto) { return Answer{}; });
  const auto client = unit.client();
  const Deadline soon(milliseconds(900));
  const auto words = client->read(kHolding, 2782, 2);
  ASSERT_FALSE(words);
  EXPECT_EQ(words.error().kind, FaultKind::timeout);
  EXPECT_NE(text(words.error()).find("unit 1 read 2782+2: no reply in 60 ms"), std::string::npos)
      << text(words.error());
  EXPECT_EQ(unit.requests(), 3);
  EXPECT_FALSE(soon.has_passed());
}

TEST(ModbusTcp, EndsExchangeWithUnitThatSendsSlowly) {
  Unit unit([](int, const auto& request, auto) { return Answer{{good(request).front()}}; });
  const auto client = unit.client();
  const Deadline soon(milliseconds(900));
  EXPECT_EQ(client->read(kHolding, 1, 1).error().kind, FaultKind::timeout);
  EXPECT_FALSE(soon.has_passed());
}

TEST(ModbusTcp, AcceptsMiscountedReplyIfLinkPermits) {
  const LoopbackServer server([](std::span<const std::byte> frame) {
    auto reply = good(decode_request(frame).value());
    reply[5] = std::byte{11};
    return Answer{reply};
  });
  ModbusLink link;
  link.timeout = kTimeout;
  const auto write = [&] {
    return make_modbus(server.address(), link)->write(WriteFunction::registers, 43, Words{220, 0});
  };
  EXPECT_EQ(write().error().what, "length of the reply is 11, expected 6");
  link.miscounts_write_replies = true;
  EXPECT_TRUE(write());
}

/// A unit that deviates from the standard, and clients with and without tolerance for it.
class DeviatingUnit {
 public:
  explicit DeviatingUnit(std::function<void(std::vector<std::byte>& reply)> deviate)
      : server_([deviate = std::move(deviate)](std::span<const std::byte> frame) {
          auto reply = good(decode_request(frame).value());
          deviate(reply);
          return Answer{reply};
        }) {}

  [[nodiscard]] std::unique_ptr<Registers> client(bool ModbusLink::*tolerance = nullptr) const {
    ModbusLink link;
    link.timeout = kTimeout;
    if (tolerance) link.*tolerance = true;
    return make_modbus(server_.address(), link);
  }

 private:
  LoopbackServer server_;
};

TEST(ModbusTcp, ToleratesDeviationOnlyIfLinkPermits) {
  struct Deviation {
    std::size_t at;  ///< offset in the header
    std::uint8_t byte;
    bool ModbusLink::*tolerance;
  };
  for (const auto& [at, byte, tolerance] :
       {Deviation{1, 0, &ModbusLink::returns_other_transaction},
        Deviation{0, 0x7F, &ModbusLink::returns_other_transaction}, Deviation{6, 0, &ModbusLink::returns_other_unit},
        Deviation{6, 255, &ModbusLink::returns_other_unit}}) {
    const DeviatingUnit unit([at = at, byte = byte](auto& reply) { reply[at] = std::byte{byte}; });
    EXPECT_EQ(unit.client()->read(kHolding, 5, 2).error().kind, FaultKind::corrupted) << at;
    const auto client = unit.client(tolerance);
    EXPECT_EQ(client->read(kHolding, 5, 2).value(), (Words{5, 6}));
    EXPECT_TRUE(client->write(WriteFunction::one_register, 2782, Words{7}));
    EXPECT_TRUE(client->write(WriteFunction::registers, 2782, Words{7, 8}));
    EXPECT_EQ(client->read(kHolding, 9, 1).value(), Words{9});
    const auto other = tolerance == &ModbusLink::returns_other_unit ? &ModbusLink::returns_other_transaction
                                                                    : &ModbusLink::returns_other_unit;
    EXPECT_FALSE(unit.client(other)->read(kHolding, 5, 2)) << "another key";
    EXPECT_FALSE(unit.client(&ModbusLink::miscounts_write_replies)->read(kHolding, 5, 2)) << "another key";
  }
}

TEST(ModbusTcp, ComparesOtherFieldsOfToleratedReply) {
  for (const std::size_t at : {std::size_t{2}, std::size_t{5}, std::size_t{6}, std::size_t{7}, std::size_t{8}}) {
    const DeviatingUnit unit([at](auto& reply) {
      reply[0] = reply[1] = std::byte{0};
      reply[at] ^= std::byte{2};
    });
    EXPECT_FALSE(unit.client(&ModbusLink::returns_other_transaction)->read(kHolding, 5, 2)) << at;
  }
}

TEST(ModbusTcp, RetriesReadAfterReset) {
  Unit unit([](int number, const auto& request, auto) {
    return number == 0 ? Answer{{}, true} : Answer{good(request)};
  });
  EXPECT_TRUE(unit.client()->read(kHolding, 1, 1));
  EXPECT_EQ(unit.connections(), 2);
}

TEST(ModbusTcp, DoesNotRepeatFailedWrite) {
  Unit unit([](int, const auto&, auto) { return Answer{}; });
  const auto client = unit.client();
  EXPECT_EQ(client->write(WriteFunction::registers, 2782, Words{1, 2}).error().kind, FaultKind::timeout);
  EXPECT_EQ(unit.requests(), 1);
}

TEST(ModbusTcp, RejectsEchoOfOtherRegister) {
  Unit unit([](int, auto request, auto) {
    request.address = static_cast<std::uint16_t>(request.address + 1);
    return Answer{good(request)};
  });
  EXPECT_EQ(unit.client()->write(WriteFunction::registers, 2782, Words{1, 2}).error().kind, FaultKind::corrupted);
}

TEST(ModbusTcp, KeepsConnectionAfterNamedException) {
  Unit unit([](int number, const auto& request, auto frame) {
    return Answer{number == 0 ? encode_exception(frame, 2) : good(request)};
  });
  const auto client = unit.client();
  const auto refused = client->read(kHolding, 1, 1);
  EXPECT_EQ(refused.error().kind, FaultKind::refused);
  EXPECT_EQ(refused.error().what, "exception 2, illegal data address");
  EXPECT_TRUE(client->read(kHolding, 1, 1));
  EXPECT_EQ(unit.connections(), 1);
}

TEST(ModbusTcp, RetriesReadOfBusyUnit) {
  Unit unit([](int number, const auto& request, auto frame) {
    return Answer{number < 3 ? encode_exception(frame, number == 0 ? 5 : 6) : good(request)};
  });
  EXPECT_EQ(unit.client()->read(kHolding, 4, 1).value(), Words{4});
  EXPECT_EQ(unit.connections(), 1);
}

TEST(ModbusTcp, RestsAfterTheSecondFailureInARow) {
  TcpLine nobody;
  {
    const LoopbackServer closed([](auto) { return Answer{}; });
    nobody = closed.address();
  }
  const auto client = make_client(nobody);
  EXPECT_TRUE(client->read(kHolding, 1, 1).error().what.starts_with("no connection: "));
  EXPECT_TRUE(client->read(kHolding, 1, 1).error().what.starts_with("no connection: "));
  const auto resting = client->read(kHolding, 1, 1);
  EXPECT_EQ(resting.error().kind, FaultKind::disconnected);
  EXPECT_TRUE(resting.error().what.starts_with("no connection: ")) << resting.error().what;
  EXPECT_TRUE(resting.error().what.ends_with("; next try in 0.5 s")) << resting.error().what;
}

}  // namespace
}  // namespace gyrotherm::drivers
