#include "drivers/wires.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <charconv>

namespace gyrotherm {

Result<LineAddress> parse_line_address(std::string_view text, std::uint16_t default_port) {
  const auto wrong = [&](const char* what) {
    return failure(FaultKind::bad_file, "", fmt::format("\"{}\": {}, expected tcp://A.B.C.D:PORT", text, what));
  };
  constexpr std::string_view kScheme = "tcp://";
  auto rest = text;
  if (rest.starts_with(kScheme)) rest.remove_prefix(kScheme.size());

  const auto colon = rest.find(':');
  LineAddress address{std::string(rest.substr(0, colon)), default_port};
  if (address.host == "localhost") address.host = "127.0.0.1";
  if (in_addr numeric{}; inet_pton(AF_INET, address.host.c_str(), &numeric) != 1)
    return wrong("the host is not a numeric IPv4 address");

  if (colon != std::string_view::npos) {
    const auto digits = rest.substr(colon + 1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), address.port);
    if (error != std::errc{} || end != digits.data() + digits.size())
      return wrong("the port is not a number up to 65535");
  }
  if (address.port == 0) return wrong("the port is missing");
  return address;
}

}  // namespace gyrotherm
