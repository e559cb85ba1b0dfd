// SPDX-License-Identifier: Apache-2.0
#include "simulator/servers/supply_server.hpp"

#include <optional>
#include <string>

#include "simulator/servers/text_unit_session.hpp"

namespace gyrotherm::simulator {
namespace {

class SupplySession final : public TextUnitSession {
 public:
  SupplySession(VirtualSupply& supply, const drivers::MapLink& link) : TextUnitSession(link), supply_(supply) {}

 private:
  std::optional<std::string> answer_line(const std::string& line) override { return supply_.answer(line); }

  VirtualSupply& supply_;
};

}  // namespace

std::unique_ptr<Session> make_supply_session(VirtualSupply& supply, const drivers::MapLink& link) {
  return std::make_unique<SupplySession>(supply, link);
}

}  // namespace gyrotherm::simulator
