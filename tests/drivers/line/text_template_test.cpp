// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/text_template.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <utility>

#include "drivers/line/text_frame.hpp"

namespace gyrotherm::drivers {
namespace {

TextTemplate parse(std::string_view text, TextEncoding encoding = TextEncoding::ascii) {
  return TextTemplate::parse(text, encoding).value();
}

double number(const FieldValues& values, const char* name) { return std::get<double>(values.at(name)); }
std::string text(const FieldValues& values, const char* name) { return std::get<std::string>(values.at(name)); }

TEST(TextTemplate, FormatsNumbersInEachForm) {
  const auto send = [](const char* form, double value) {
    return parse(std::string("{value:") + form + "}").format({{"value", value}});
  };
  EXPECT_EQ(send("f", -40), "-40");
  EXPECT_EQ(send("f.1", -40), "-40.0");
  EXPECT_EQ(send("f.1", -0.04), "0.0");
  EXPECT_EQ(send("f06.1", 23), "0023.0");
  EXPECT_EQ(send("f06.1", -5.5), "-005.5");
  EXPECT_EQ(send("f06.1", -0.01), "0000.0");
  EXPECT_EQ(send("d", 2.6), "3");
  EXPECT_EQ(send("d03", 7), "007");
  EXPECT_EQ(send("x4", -4000), "F060");
  EXPECT_EQ(send("x4", 2500), "09C4");
  EXPECT_EQ(send("b1", 1), "1");
  EXPECT_EQ(send("f.2", std::nan("")), "0.00");
}

TEST(TextTemplate, ReadsWhatItFormats) {
  for (const auto* form : {"f", "f.3", "f08.3", "d", "d05", "x4", "x8"})
    for (const double value : {-123.0, -1.0, 0.0, 7.0, 120.0}) {
      const auto both = parse(std::string("a{value:") + form + "}z");
      const auto read = both.match(both.format({{"value", value}}));
      ASSERT_TRUE(read) << form << " " << value;
      EXPECT_EQ(number(*read, "value"), value) << form;
    }
}

TEST(TextTemplate, FitsOnlyWholeLines) {
  const auto answer = parse("1¶{value:f}", TextEncoding::latin1);
  EXPECT_EQ(number(answer
                       .match("1\xB6"
                              "24.4812")
                       .value(),
                   "value"),
            24.4812);
  for (const auto* line : {"1", "1\xB6",
                           "1\xB6"
                           "x",
                           "1\xB6"
                           "24.4x",
                           "01\xB6"
                           "24.4",
                           "1\xB6"
                           "24,4",
                           "1\xB6"
                           "nan",
                           "1\xB6"
                           "inf",
                           "1\xB6"
                           "0x10",
                           "-8", ""})
    EXPECT_FALSE(answer.match(line)) << line;
}

TEST(TextTemplate, RejectsNumbersThatMayBeCut) {
  const auto answer = parse("A0 {air:f05.1} {set:f05.1}");
  EXPECT_TRUE(answer.match("A0 023.4 025.7", NumberCheck::all_decimals));
  EXPECT_TRUE(answer.match("A0 023.4 025.75", NumberCheck::point));
  for (const auto* cut : {"A0 023.4 025.", "A0 023.4 025", "A0 023. 025.7"}) {
    EXPECT_FALSE(answer.match(cut, NumberCheck::point)) << cut;
    EXPECT_FALSE(answer.match(cut, NumberCheck::all_decimals)) << cut;
    EXPECT_TRUE(answer.match(cut)) << cut;
  }
  EXPECT_FALSE(parse("{value:f.2}").match("25.7", NumberCheck::all_decimals));
  EXPECT_TRUE(parse("{value:f}").match("25", NumberCheck::all_decimals));
  EXPECT_TRUE(parse("{value:d}").match("25", NumberCheck::all_decimals));
}

TEST(TextTemplate, RejectsNumbersOfMoreThan40Characters) {
  const auto answer = parse("{value:f}");
  EXPECT_TRUE(answer.match(std::string(38, '9') + ".5"));
  EXPECT_FALSE(answer.match(std::string(39, '9') + ".5"));
}

TEST(TextTemplate, AcceptsAnyNumberOfBlanksForABlank) {
  const auto answer = parse("{a:f}, {b:f}");
  for (const auto* line : {"1,2", "1, 2", "1,  2", " 1, +2"}) EXPECT_TRUE(answer.match(line)) << line;
  EXPECT_FALSE(answer.match("1;2"));
}

TEST(TextTemplate, ReadsOptionalGroupsAndTexts) {
  const auto monitor = parse("{_:f}, [{humidity:f}], {mode:s}, {alarms:d}");
  const auto with = monitor.match("23.0,85,CONSTANT,0").value();
  EXPECT_EQ(number(with, "humidity"), 85);
  EXPECT_EQ(text(with, "mode"), "CONSTANT");
  const auto without = monitor.match("23.0,,STANDBY,2").value();
  EXPECT_FALSE(without.contains("humidity"));
  EXPECT_EQ(number(without, "alarms"), 2);
  EXPECT_FALSE(monitor.match("23.0,85,CONSTANT"));
}

TEST(TextTemplate, ReadsListsAndDigits) {
  const auto scan = parse("1;{value:f*3,}");
  EXPECT_EQ(std::get<std::vector<double>>(scan.match("1;+2.0E+01,-3,9.90000000E+37").value().at("value")),
            (std::vector<double>{20, -3, 9.9e37}));
  EXPECT_FALSE(scan.match("1;1,2"));
  EXPECT_FALSE(scan.match("1;1,2,3,4"));
  const auto digits = parse("{_:b1}{run:b1}{rest:b30}");
  const auto read = digits.match("01000000000000000000000000000001").value();
  EXPECT_EQ(number(read, "run"), 1);
  EXPECT_EQ(text(read, "rest"), "000000000000000000000000000001");
  EXPECT_FALSE(digits.match("0200000000000000000000000000000"));
}

TEST(TextTemplate, KeepsDoubledBrackets) {
  const auto huber = parse("{{M00{value:x4}");
  EXPECT_EQ(huber.format({{"value", -4000.0}}), "{M00F060");
  EXPECT_EQ(parse("a[[b").format({}), "a[b");
}

TEST(TextTemplate, RefusesTextThatIsNoTemplate) {
  for (const auto* wrong : {"{value", "{value}", "{value:q}", "{:f}", "{value:f.}", "{value:s0}", "{value:x}",
                            "{value:b}", "[a", "[]", "[a[b]]", "{a:s}{b:s}", "{a:f}{a:f}", "{a:f*0,}", "{a:x9}", "¶"})
    EXPECT_EQ(TextTemplate::parse(wrong, TextEncoding::ascii).error().kind, FaultKind::bad_file) << wrong;
}

TEST(TextTemplate, EndsOnLinesThatFitInManyWays) {
  const auto many = parse("{a:s}x{b:s}x{c:s}x{d:s}x{e:s}x{f:s}y");
  EXPECT_FALSE(many.match(std::string(2000, 'x')));
}

// Published frames of CTS chambers: DESY's driver and the maker's page, as quoted in the protocol descriptions.
TEST(TextFrame, HasPublishedBytesOfCts) {
  const TextFrame cts{.high_bit = true, .checksum = FrameChecksum::exclusive_or};
  const auto framed = [&](const char* text) { return to_frame(cts, std::string("\x01") + text); };
  EXPECT_EQ(framed("A0"), "\x02\x81\xC1\xB0\xF0\x03");
  EXPECT_EQ(framed("S"), "\x02\x81\xD3\xD2\x03");
  EXPECT_EQ(framed("s1 1"), "\x02\x81\xF3\xB1\xA0\xB1\xD2\x03");
  EXPECT_EQ(framed("s1 0"), "\x02\x81\xF3\xB1\xA0\xB0\xD3\x03");
  EXPECT_EQ(from_frame(cts, "\x02\x81\xC1\xB0\xF0\x03").value(),
            "\x01"
            "A0");
  EXPECT_FALSE(from_frame(cts, "\x02\x81\xC1\xB0\xF1\x03"));
}

// Published frame of ASCII-1 of a SIMPAC controller: checksum "8E".
TEST(TextFrame, HasPublishedBytesOfAscii1) {
  const TextFrame ascii1{.checksum = FrameChecksum::negated_sum};
  EXPECT_EQ(to_frame(ascii1, "1?"),
            "\x02"
            "1?8E\x03");
  EXPECT_EQ(from_frame(ascii1,
                       "\x02"
                       "1?8E\x03")
                .value(),
            "1?");
}

TEST(TextFrame, HasPlainSum) {
  const TextFrame sum{.end = '\r', .checksum = FrameChecksum::sum};
  // The sum from STX to ETX, as two hexadecimal digits before CR.
  const std::string data = "011R01001\x03";
  unsigned expected = 2;
  for (const char c : data) expected += static_cast<unsigned char>(c);
  const auto frame = to_frame(sum, data);
  EXPECT_EQ(frame, "\x02" + data + fmt::format("{:02X}", expected & 0xFF) + "\r");
  EXPECT_EQ(from_frame(sum, frame).value(), data);
  auto broken = frame;
  broken[3] = '7';
  EXPECT_FALSE(from_frame(sum, broken));
  EXPECT_FALSE(from_frame({.end = '\r', .checksum = FrameChecksum::negated_sum}, frame));
}

/// A line on which bytes arrive in pieces of one size.
class BytesInPieces final : public ByteStream {
 public:
  BytesInPieces(std::string bytes, std::size_t piece) : left_(std::move(bytes)), piece_(piece) {}
  Result<std::size_t> read(std::span<std::byte> buffer, Duration) override {
    if (left_.empty()) return failure(FaultKind::timeout, "pieces", "nothing came");
    const auto bytes = left_.substr(0, std::min(piece_, buffer.size()));
    left_.erase(0, bytes.size());
    std::ranges::copy(std::as_bytes(std::span(bytes)), buffer.begin());
    return bytes.size();
  }
  Result<void> write(std::span<const std::byte>, Duration) override { return {}; }

 private:
  std::string left_;
  std::size_t piece_;
};

/// Returns the texts of all frames in the bytes, each with its terminator, or the kind of the first fault other than
/// the end of the bytes.
tl::expected<std::string, FaultKind> read_frames(const TextFrame& form, const std::string& bytes, std::size_t piece) {
  const auto stream = make_framed_stream(std::make_unique<BytesInPieces>(bytes, piece), form);
  std::string all;
  while (true) {
    std::array<std::byte, 64> buffer;
    const auto size = stream->read(buffer, std::chrono::seconds(1));
    if (!size && size.error().kind == FaultKind::timeout) return all;
    if (!size) return tl::unexpected(size.error().kind);
    all.append(reinterpret_cast<const char*>(buffer.data()), *size);
  }
}

TEST(TextFrame, CheckByteMayBeStartOrEndByte) {
  const TextFrame usual{.checksum = FrameChecksum::exclusive_or};
  const TextFrame other{.begin = '#', .end = '\r', .checksum = FrameChecksum::exclusive_or};
  int starts = 0, ends = 0;
  for (const auto& form : {usual, other})
    for (int first = ' '; first < 0x7F; first += 3)
      for (char second = ' '; second < '\x7F'; ++second) {
        const std::string text{'1', static_cast<char>(first), second};
        if (text.find(form.begin) != std::string::npos) continue;
        const auto frame = to_frame(form, text);
        starts += frame[4] == form.begin ? 1 : 0;
        ends += frame[4] == form.end ? 1 : 0;
        const auto expected = text + form.end;
        for (const std::size_t piece : {1, 2, 100}) {
          ASSERT_EQ(read_frames(form, frame, piece), expected) << text;
          ASSERT_EQ(read_frames(form, frame + frame, piece), expected + expected) << text;
          ASSERT_EQ(read_frames(form, "noise" + frame + "x", piece), expected) << text;
        }
      }
  EXPECT_GT(starts, 20);
  EXPECT_GT(ends, 20);
}

TEST(TextFrame, WrongCheckByteIsCorrupted) {
  const TextFrame form{.checksum = FrameChecksum::exclusive_or};
  for (const auto* text : {"AB", "T=23.5", "A"})
    for (int byte = 0; byte < 0x80; ++byte) {
      auto frame = to_frame(form, text);
      auto& check = frame[frame.size() - 2];
      if (check == byte) continue;
      check = static_cast<char>(byte);
      for (const std::size_t piece : {1, 100}) {
        const auto found = read_frames(form, frame, piece);
        ASSERT_FALSE(found) << text << " " << byte;
        EXPECT_EQ(found.error(), FaultKind::corrupted);
      }
    }
}

TEST(TextFrame, DescribesFramesWithoutRecognisableEnd) {
  using enum FrameChecksum;
  for (const auto checksum : {none, exclusive_or, negated_sum, sum}) {
    EXPECT_EQ(describe_ambiguity({.checksum = checksum}), "");
    EXPECT_NE(describe_ambiguity({.begin = '~', .end = '~', .checksum = checksum}), "");
    const bool has_digits = checksum == negated_sum || checksum == sum;
    for (const char digit : {'0', '9', 'A', 'F'}) {
      EXPECT_EQ(describe_ambiguity({.end = digit, .checksum = checksum}).empty(), !has_digits);
      EXPECT_EQ(describe_ambiguity({.begin = digit, .checksum = checksum}).empty(), !has_digits);
    }
    EXPECT_EQ(describe_ambiguity({.end = '\0', .checksum = checksum}).empty(), checksum != exclusive_or);
    EXPECT_EQ(describe_ambiguity({.end = '\0', .high_bit = true, .checksum = checksum}), "");
  }
}

TEST(TextTemplate, ReadsColumnsOfNumbersWithoutLiterals) {
  const auto status = parse("T{error:d1}{air_temperature:d5}{set_point:d5}{mode:d1}");
  const auto fields = status.match("T0+0220-02001").value();
  EXPECT_EQ(number(fields, "error"), 0);
  EXPECT_EQ(number(fields, "air_temperature"), 220);
  EXPECT_EQ(number(fields, "set_point"), -200);
  EXPECT_EQ(number(fields, "mode"), 1);
  EXPECT_EQ(status.format(fields), "T000220-02001");
  EXPECT_EQ(status.match(status.format(fields)), fields) << "a virtual unit can be read";
  for (const auto* wrong : {"T0+0220+020", "T0+022+02000", "T0+022x+02000", "T 0+0220-02001", "T0"})
    EXPECT_FALSE(status.match(wrong)) << wrong;
  const auto mixed = parse("{a:f05.1}{b:x2}{c:d2}{d:b1}{e:d3}{f:s2}7{g:f04.1}8");
  const auto values = mixed.match("-12.5FF 31007C 79.508").value();
  EXPECT_EQ(number(values, "a"), -12.5);
  EXPECT_EQ(number(values, "c"), 3);
  EXPECT_EQ(number(values, "e"), 7);
  EXPECT_EQ(text(values, "f"), "C ");
  EXPECT_EQ(number(values, "g"), 9.5);
  const auto optional = parse("{a:d2}[{b:d2}]{c:s1}");
  EXPECT_EQ(number(optional.match("1234x").value(), "a"), 12);
  EXPECT_EQ(number(optional.match("12x").value(), "a"), 12);
  EXPECT_EQ(number(parse("[{a:d2}]{b:d2}").match("0712").value(), "a"), 7);
}

TEST(TextTemplate, RejectsNumbersWithTwoSigns) {
  for (const auto* form : {"{a:f}", "{a:f.1}", "{a:+f.1}", "{a:f06.1}x", "{a:d}", "{a:+d}", "{a:d5}x", "{a:f*2,}"})
    for (const auto* line :
         {"+-25.0", "-+25.0", "++25.0", "--25.0", "+-25", "+ 25", "- 25", "+", "-", "+-", "+-25.0x", "+-025x", "1,+-2"})
      EXPECT_FALSE(parse(form).match(line)) << form << " " << line;
  EXPECT_EQ(number(parse("{a:f.1}").match("+25.0").value(), "a"), 25);
  EXPECT_EQ(number(parse("{a:+d}").match("-25").value(), "a"), -25);
  for (const auto* wrong : {"{a:f.-0}", "{a:f5.-0}", "{a:f*-0,}", "{a:f.+1}"})
    EXPECT_FALSE(TextTemplate::parse(wrong, TextEncoding::ascii)) << wrong;
}

TEST(TextTemplate, RefusesNumbersWithoutEnd) {
  for (const auto* wrong : {"{a:d}{b:d2}", "{a:f.1}{b:d2}", "{a:f}{b:x2}", "{a:d}{b:b8}", "{a:d}0", "{a:d}[{b:d2}]",
                            "[{a:d}]{b:d2}", "{a:d}[C]{b:d}", "{a:f*2,}{b:d}", "{a:d}[ {b:d}]5"}) {
    const auto made = TextTemplate::parse(wrong, TextEncoding::ascii);
    ASSERT_FALSE(made) << wrong;
    EXPECT_NE(made.error().what.find("the end of the number {a} cannot be found"), std::string::npos);
  }
  for (const auto* good : {"{a:d}C{b:d2}", "{a:f.1} {b:d}", "{a:d}{b:+d}", "{a:f}{b:s}", "{a:f.1}{_:s3}", "{a:d}[C]",
                           "0{a:d}", "{a:s1}{b:d}", "{a:x2}{b:d}", "{a:d}[ {b:d}]"})
    EXPECT_TRUE(TextTemplate::parse(good, TextEncoding::ascii)) << good;
}

TEST(TextTemplate, SignEndsNumberBefore) {
  const auto limits = parse("QR C{highest:d}{lowest:+d}");
  const auto fields = limits.match("QR C200-100").value();
  EXPECT_EQ(number(fields, "highest"), 200);
  EXPECT_EQ(number(fields, "lowest"), -100);
  EXPECT_EQ(limits.format(fields), "QR C200-100");
  EXPECT_EQ(number(limits.match("QR C85+5").value(), "lowest"), 5);
  EXPECT_FALSE(limits.match("QR C855"));
  EXPECT_EQ(parse("{value:+f06.1}").format({{"value", 22.0}}), "+022.0");
  EXPECT_EQ(parse("{value:+f.1}").format({{"value", -0.01}}), "+0.0");
  EXPECT_EQ(parse("{value:+d}").format({{"value", 0.0}}), "+0");
  for (const auto* wrong : {"{a:+x2}", "{a:+s}", "{a:+}", "{a:d+}"})
    EXPECT_FALSE(TextTemplate::parse(wrong, TextEncoding::ascii)) << wrong;
}

TEST(TextTemplate, RecognisesValuesThatDoNotFit) {
  const auto column = parse("W{a:d3}{b:d1}");
  for (const auto& [value, fits] : {std::pair(999.0, true), std::pair(-99.0, true), std::pair(1000.0, false),
                                    std::pair(-100.0, false), std::pair(999.6, false)})
    EXPECT_EQ(column.can_format({{"a", value}}), fits) << value;
  const auto signed_digits = parse("W{a:x4}"), digits = parse("W{a:u4}");
  for (const auto& [value, fits, fits_unsigned] :
       {std::tuple(32767.0, true, true), std::tuple(32768.0, false, true), std::tuple(-32768.0, true, false),
        std::tuple(-32769.0, false, false), std::tuple(65536.0, false, false)}) {
    EXPECT_EQ(signed_digits.can_format({{"a", value}}), fits) << value;
    EXPECT_EQ(digits.can_format({{"a", value}}), fits_unsigned) << value;
  }
  EXPECT_TRUE(parse("W{a:d3}").can_format({{"a", 12345.0}})) << "a minimum width";
  for (const double huge : {1e16, 1e300, -1e300, std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(signed_digits.can_format({{"a", huge}})) << huge;
    EXPECT_EQ(signed_digits.format({{"a", huge}}), "W0000") << huge;
  }
}

TEST(TextTemplate, ReadsColumnsOfCharactersWithoutLiterals) {
  const auto form = parse("{power:s1}{error:s1}{mode:s2}{rest:s}");
  const auto fields = form.match("YNABcd e").value();
  EXPECT_EQ(std::get<std::string>(fields.at("power")), "Y");
  EXPECT_EQ(std::get<std::string>(fields.at("error")), "N");
  EXPECT_EQ(std::get<std::string>(fields.at("mode")), "AB");
  EXPECT_EQ(std::get<std::string>(fields.at("rest")), "cd e");
  EXPECT_FALSE(form.match("YNA")) << "too short";
  EXPECT_TRUE(form.match("YNAB"));
  for (const auto* refused : {"{a:s}{b:s}", "{a:s}{b:s1}"}) {
    const auto made = TextTemplate::parse(refused, TextEncoding::ascii);
    ASSERT_FALSE(made) << refused;
    EXPECT_NE(made.error().what.find("{value:s4}"), std::string::npos) << made.error().what;
  }
}

}  // namespace
}  // namespace gyrotherm::drivers
