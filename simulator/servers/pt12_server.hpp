// SPDX-License-Identifier: Apache-2.0
/// The virtual RH Systems PT12's side of its command language (manual of 7/20/2021, chapter 5).
#pragma once

#include "drivers/thermometer/pt12_codec.hpp"
#include "simulator/servers/session.hpp"
#include "simulator/virtual_laboratory.hpp"

namespace gyrotherm::simulator {

/// Answers ID?, SN?, T?, T1? to T12? and CONNECTED?, in any letter case, five decimals. Anything else has no reply. An
/// input without a thermometer reads NaN.
class Pt12Session final : public TextSession {
 public:
  using Inputs = simulator::Inputs<drivers::kPt12Inputs>;

  /// `world` must outlive this.
  Pt12Session(const VirtualLaboratory& laboratory, const Inputs& inputs)
      : TextSession('\r'), laboratory_(laboratory), inputs_(inputs) {}

 private:
  [[nodiscard]] std::string answer(std::string_view command) const override;
  [[nodiscard]] std::string connected() const;

  const VirtualLaboratory& laboratory_;
  Inputs inputs_;
};

}  // namespace gyrotherm::simulator
