/// The virtual Lake Shore 218's side of its command language (user's manual pp. 6-10 to 6-29).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/thermometer/lakeshore_218_codec.hpp"
#include "simulator/session.hpp"
#include "simulator/world.hpp"

namespace gyrotherm {

/// Answers *IDN?, CRDG? and KRDG? (no argument or 0: all eight inputs; 1…8: one), three decimals. Anything else has no
/// reply, as on the instrument. An input without a thermometer reads 0 K.
class Lakeshore218Session final : public Session {
 public:
  using Inputs = std::array<std::optional<std::size_t>, kLakeshore218Inputs>;  ///< indices of the world's thermometers

  /// `world` must outlive this.
  Lakeshore218Session(const World& world, const Inputs& inputs) : world_(world), inputs_(inputs) {}
  [[nodiscard]] bool feed(std::span<const std::byte> bytes, std::vector<std::byte>& reply) override;

 private:
  [[nodiscard]] std::string answer(std::string_view command) const;
  [[nodiscard]] std::string readings(std::string_view argument, double zero_c) const;

  const World& world_;
  Inputs inputs_;
  std::string line_;      ///< the beginning of a command
  bool line_too_long_{};  ///< what is left of it is skipped
};

}  // namespace gyrotherm
