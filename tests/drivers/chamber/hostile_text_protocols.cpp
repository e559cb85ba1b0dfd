// SPDX-License-Identifier: Apache-2.0
// Protocols of the text instruments, from the public drivers and manuals that docs/text-instruments.md names.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "tests/drivers/chamber/hostile_text_unit.hpp"

namespace gyrotherm::drivers {
namespace {

using Constants = std::map<std::string, std::string>;
using Answer = std::optional<std::string>;

/// Returns the text after `begin` if the line begins with it.
std::optional<std::string> rest_after(const std::string& line, std::string_view begin) {
  return line.starts_with(begin) ? std::optional(line.substr(begin.size())) : std::nullopt;
}

Answer constant(const Constants& constants, const std::string& line) {
  const auto found = constants.find(line);
  return found == constants.end() ? Answer() : found->second;
}

void take_set_point(TextTruth& truth, const std::string& value) {
  truth.set_point_c = std::strtod(value.c_str(), nullptr);
}

/// A published address byte, 8O1 frame: STX, address and data with bit 7, their exclusive-or, ETX.
std::string cts_frame(const std::string& text) {
  std::string data(1, '\x81');
  for (const char byte : text) data += static_cast<char>(byte | 0x80);
  unsigned char check = 0;
  for (const char byte : data) check ^= static_cast<unsigned char>(byte);
  return '\x02' + data + static_cast<char>(check | 0x80) + '\x03';
}

std::string cts_unframe(const std::string& bytes) {
  if (bytes.size() < 5 || cts_frame({}).front() != bytes.front()) return "not a frame";
  std::string text;
  for (const char byte : bytes.substr(2, bytes.size() - 4)) text += static_cast<char>(byte & 0x7F);
  return cts_frame(text) == bytes ? text : "not a frame";
}

TextProtocol simserv() {
  static const Constants kConstants{{"99997\xB6\x31\xB6\x31", "1\xB6LabEvent T/210/70/5"},
                                    {"99997\xB6\x31\xB6\x33", "1\xB6\x35\x39\x32\x32"},
                                    {"11007\xB6\x31\xB6\x31", "1\xB6-75.0"},
                                    {"11009\xB6\x31\xB6\x31", "1\xB6\x31\x38\x35.0"},
                                    {"11066\xB6\x31\xB6\x31", "1\xB6\x30.0"},
                                    {"11070\xB6\x31\xB6\x31", "1\xB6\x30.0"},
                                    {"14003\xB6\x31\xB6\x31", "1\xB6\x31"},
                                    {"10012\xB6\x31", "1\xB6\x33"},
                                    {"19210\xB6\x31", "1\xB6\x30"},
                                    {"14001\xB6\x31\xB6\x31\xB6\x31", "1"},
                                    {"19015\xB6\x31", "1"}};
  return {.name = "simserv",
          .file = "weiss_simserv",
          .question_end = "\r",
          .answer_end = "\r\n",
          .busy = "-8",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == "11004\xB6\x31\xB6\x31") return fmt::format("1\xB6{:.4f}", truth.next_air());
            if (line == "11002\xB6\x31\xB6\x31") return fmt::format("1\xB6{:.1f}", truth.note_set_point());
            if (const auto value = rest_after(line, "11001\xB6\x31\xB6\x31\xB6"))
              return take_set_point(truth, *value), "1";
            return constant(kConstants, line);
          },
          .other_question = "11004\xB6\x31\xB6\x31"};
}

TextProtocol ascii2() {
  return {.name = "ascii2",
          .file = "weiss_ascii2",
          .question_end = "\r",
          .answer_end = "\r",
          .busy = "",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            const std::string digits = "01" + std::string(30, '0');
            if (line == "$01?") return "ASCII-2 PROTOCOL CONFIGURATION\r\n\r\nE-string: $01E CV CV 32 digits";
            if (line == "$01I") {
              const double set_point = truth.note_set_point();
              return fmt::format(
                  "{:06.1f} {:06.1f} 0045.0 0045.4 0080.0 0080.0 0000.0 0000.0 0000.0 0000.0 0000.0 "
                  "0000.0 0000.0 0000.0 {}",
                  set_point, truth.next_air(), digits);
            }
            if (const auto value = rest_after(line, "$01E ")) return take_set_point(truth, *value), "0";
            return {};
          },
          .other_question = "$01I",
          .acknowledges = false};
}

TextProtocol espec() {
  static const Constants kConstants{{"TYPE?", "T,P-300,190.0"},
                                    {"ROM?", "JMIC -S1.00"},
                                    {"MODE?", "CONSTANT"},
                                    {"MODE?,DETAIL", "CONSTANT"},
                                    {"MODE, CONSTANT", "OK:MODE,CONSTANT"},
                                    {"PRGM, END, CONST", "NA:CONT NOT READY-2"}};
  return {.name = "espec",
          .file = "espec_p300",
          .question_end = "\r\n",
          .answer_end = "\r\n",
          .busy = "NA:DATA NOT READY",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == "TEMP?") {
              const double air = truth.next_air();
              return fmt::format("{:.1f},{:.1f},105.0,-45.0", air, truth.note_set_point());
            }
            if (line == "MON?") return "23.0,,CONSTANT,0";
            if (const auto value = rest_after(line, "TEMP, S")) {
              take_set_point(truth, *value);
              return "OK:TEMP,S" + *value;
            }
            return constant(kConstants, line);
          },
          .other_question = "TEMP?"};
}

TextProtocol thermotron() {
  static const Constants kConstants{{"IDEN?", "THERMOTRON 8800"},
                                    {"VRSN?", "5.11"},
                                    {"MRMP1?", "0.000"},
                                    {"SCOD?", "1"},
                                    {"ALRM1?", "0"},
                                    {"RUNM", "0"}};
  return {.name = "thermotron",
          .file = "thermotron_8800",
          .question_end = "\r",
          .answer_end = "\r\n",
          .busy = "3",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == "PVAR1?") return fmt::format("{:.3f}", truth.next_air());
            if (line == "SETP1?") return fmt::format("{:.3f}", truth.note_set_point());
            if (const auto value = rest_after(line, "SETP1,")) return take_set_point(truth, *value), "0";
            return constant(kConstants, line);
          },
          .other_question = "PVAR1?"};
}

Answer cts_answer(TextTruth& truth, const std::string& line) {
  static const Constants kConstants{{"U1", "U1 999.9 999.9"}, {"S", std::string("S10100000\0", 10)}, {"s1 1", "s1"}};
  if (line == "A0") {
    const double air = truth.next_air();
    return fmt::format("A0 {:05.1f} {:05.1f}", air, truth.note_set_point());
  }
  if (const auto value = rest_after(line, "a0 ")) return take_set_point(truth, *value), "a";
  return constant(kConstants, line);
}

TextProtocol cts() {
  return {.name = "cts",
          .file = "cts",
          .question_end = "",
          .answer_end = "",
          .busy = "",
          .respond = cts_answer,
          .other_question = "A0"};
}

TextProtocol cts_serial() {
  return {.name = "cts_serial",
          .file = "cts",
          .question_end = "",
          .answer_end = "",
          .busy = "",
          .respond = cts_answer,
          .other_question = "A0",
          .is_serial = true,
          .frame = cts_frame,
          .unframe = cts_unframe};
}

TextProtocol julabo() {
  static const Constants kConstants{{"version", "JULABO FL300 VERSION 1.2"},
                                    {"in_mode_05", "1"},
                                    {"in_sp_06", "0"},
                                    {"in_mode_01", "0"},
                                    {"in_sp_03", "90.00"},
                                    {"in_sp_04", "-40.00"},
                                    {"status", "03 REMOTE START"}};
  return {.name = "julabo",
          .file = "julabo",
          .question_end = "\r",
          .answer_end = "\r\n",
          .busy = "",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == "in_pv_00") return fmt::format("{:.2f}", truth.next_air());
            if (line == "in_sp_00") return fmt::format("{:.2f}", truth.note_set_point());
            if (const auto value = rest_after(line, "out_sp_00 ")) return take_set_point(truth, *value), Answer();
            return constant(kConstants, line);
          },
          .other_question = "in_pv_00",
          .is_serial = true,
          .acknowledges = false};
}

std::string hundredths(double celsius) {
  return fmt::format("{:04X}", static_cast<unsigned>(static_cast<int>(std::lround(celsius * 100))) & 0xFFFFU);
}

TextProtocol huber() {
  static const Constants kConstants{{"{M1B****", "{S1B51A4"}, {"{M1C****", "{S1C0003"}, {"{M30****", "{S30F060"},
                                    {"{M31****", "{S312328"}, {"{M14****", "{S140001"}, {"{M0A****", "{S0A0013"},
                                    {"{M05****", "{S050000"}, {"{M140001", "{S140001"}};
  return {.name = "huber",
          .file = "huber",
          .question_end = "\r\n",
          .answer_end = "\r\n",
          .busy = "",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == "{M01****") return "{S01" + hundredths(truth.next_air());
            if (line == "{M00****") return "{S00" + hundredths(truth.note_set_point());
            if (const auto value = rest_after(line, "{M00"); value && value->size() == 4) {
              truth.set_point_c = static_cast<std::int16_t>(std::strtol(value->c_str(), nullptr, 16)) / 100.0;
              return "{S00" + *value;
            }
            return constant(kConstants, line);
          },
          .other_question = "{M01****"};
}

TextProtocol lauda() {
  static const Constants kConstants{
      {"TYPE", "RP245E"}, {"IN_MODE_02", "0"}, {"STATUS", "0"},        {"IN_MODE_01", "0"},    {"IN_MODE_04", "0"},
      {"RMP_IN_05", "0"}, {"START", "OK"},     {"IN_SP_04", "200.00"}, {"IN_SP_05", "-50.00"}, {"RMP_STOP", "OK"}};
  return {.name = "lauda",
          .file = "lauda",
          .question_end = "\r\n",
          .answer_end = "\r\n",
          .busy = "ERR_2",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == "IN_PV_00") return fmt::format("{:06.2f}", truth.next_air());
            if (line == "IN_SP_00") return fmt::format("{:06.2f}", truth.note_set_point());
            if (const auto value = rest_after(line, "OUT_SP_00_")) return take_set_point(truth, *value), "OK";
            return constant(kConstants, line);
          },
          .other_question = "IN_PV_00",
          .is_serial = true};
}

TextProtocol f4t_scpi() {
  static const Constants kConstants{
      {"*IDN?", "WATLOW ELECTRIC MANUFACTURING COMPANY,F4T1A2EAA1B1AAA,0000815,04.07:0012"},
      {":UNIT:TEMPERATURE?", "C"},
      {":SOURCE:CLOOP1:ERROR?", "NONE"},
      {":SOURCE:CLOOP1:RACTION?", "OFF"},
      {":OUTPUT1:STATE?", "ON"}};
  return {.name = "f4t_scpi",
          .file = "watlow_f4t_scpi",
          .question_end = "\n",
          .answer_end = "\n",
          .busy = "",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == ":SOURCE:CLOOP1:PVALUE?") return fmt::format("{:.2f}", truth.next_air());
            if (line == ":SOURCE:CLOOP1:SPOINT?") return fmt::format("{:.2f}", truth.note_set_point());
            if (const auto value = rest_after(line, ":SOURCE:CLOOP1:SPOINT "))
              return take_set_point(truth, *value), Answer();
            return constant(kConstants, line);
          },
          .other_question = ":SOURCE:CLOOP1:PVALUE?",
          .acknowledges = false};
}

TextProtocol keysight_34970a() {
  return {.name = "34970a",
          .file = "keysight_34970a",
          .question_end = "\n",
          .answer_end = "\n",
          .busy = "",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == "*IDN?") return "HEWLETT-PACKARD,34970A,0,13-2-2";
            if (line == "SYST:ERR?") return "+0,\"No error\"";
            if (line != "INIT;*OPC?;FETC?") return {};
            truth.scan(8);
            std::string all = "1;";
            for (const double reading : truth.inputs_c)
              all += fmt::format("{}{:+.8E}", all == "1;" ? "" : ",", reading);
            return all;
          },
          .other_question = "INIT;*OPC?;FETC?",
          .inputs = 8};
}

/// Each input has its own question; a status follows. The truth is that of the latest question of the input.
TextProtocol lakeshore_336() {
  return {.name = "336",
          .file = "lakeshore_336",
          .question_end = "\r\n",
          .answer_end = "\r\n",
          .busy = "",
          .respond = [](TextTruth& truth, const std::string& line) -> Answer {
            if (line == "*IDN?") return "LSCI,MODEL336,LSA22VS/1234567,2.8";
            if (line.starts_with("RDGST? ")) return "000";
            const auto input = rest_after(line, "CRDG? ");
            if (!input || input->size() != 1) return {};
            const auto index = static_cast<std::size_t>(input->front() - 'A');
            truth.inputs_c.resize(4);
            truth.inputs_c[index] = truth.next_air() + 40 * static_cast<double>(index);
            return fmt::format("{:+08.3f}", truth.inputs_c[index]);
          },
          .other_question = "CRDG? A",
          .inputs = 4};
}

}  // namespace

const std::vector<TextProtocol>& text_protocols() {
  static const std::vector<TextProtocol> kAll{simserv(), ascii2(),     espec(),           thermotron(),
                                              cts(),     cts_serial(), julabo(),          huber(),
                                              lauda(),   f4t_scpi(),   keysight_34970a(), lakeshore_336()};
  return kAll;
}

}  // namespace gyrotherm::drivers
