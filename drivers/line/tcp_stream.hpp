/// A byte stream over TCP.
#pragma once

#include <memory>

#include "drivers/line/line_address.hpp"

namespace gyrotherm {

/// Connects at first use, and again after the line broke; a connection has `connect_within` to come about.
/// After a second failure in a row the line rests 0.5 s, then longer, up to 10 s; until then every use fails at once.
[[nodiscard]] std::unique_ptr<ByteStream> make_tcp_stream(const TcpLine& line, Duration connect_within);

}  // namespace gyrotherm
