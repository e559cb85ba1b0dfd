// SPDX-License-Identifier: Apache-2.0
/// The virtual Lake Shore 218's side of its command language (user's manual pp. 6-10 to 6-29).
#pragma once

#include "drivers/thermometer/lakeshore_218_codec.hpp"
#include "simulator/servers/session.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Answers *IDN?, CRDG? and KRDG? (no argument or 0: all eight inputs; 1…8: one), three decimals. Anything else has no
/// reply, as on the instrument. An input without a thermometer reads 0 K.
class Lakeshore218Session final : public TextSession {
 public:
  using Inputs = simulator::Inputs<drivers::kLakeshore218Inputs>;

  /// `world` must outlive this.
  Lakeshore218Session(const VirtualLaboratory& laboratory, const Inputs& inputs)
      : TextSession('\n'), laboratory_(laboratory), inputs_(inputs) {}

 private:
  [[nodiscard]] std::string answer(std::string_view command) const override;
  [[nodiscard]] std::string readings(std::string_view argument, double zero_c) const;

  const VirtualLaboratory& laboratory_;
  Inputs inputs_;
};

}  // namespace gyrotherm::simulator
