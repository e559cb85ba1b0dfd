// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exchange/known_formats.hpp"

#include <array>

namespace gyrotherm::exchange {

namespace {

struct KnownFormat {
  std::string_view beginning;
  std::string_view way_out;
};

constexpr std::string_view kZip("PK\x03\x04", 4);

constexpr std::array<KnownFormat, 14> kKnown{{
    {std::string_view("BZh", 3), "bzip2: unpack it first, \"bunzip2 -k FILE\""},
    {std::string_view("\xFD"
                      "7zXZ\0",
                      6),
     "xz: unpack it first, \"unxz -k FILE\""},
    {std::string_view("\x28\xB5\x2F\xFD", 4), "zstd: unpack it first, \"unzstd FILE\""},
    {std::string_view("7z\xBC\xAF\x27\x1C", 6), "a 7-Zip archive: unpack it first"},
    {std::string_view("Rar!\x1A", 5), "a RAR archive: unpack it first"},
    {std::string_view("\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", 8),
     "a workbook of old Excel: save the sheet as CSV, \"soffice --convert-to csv FILE\""},
    {"MATLAB 5.0 MAT-file", "a MATLAB file of version 5 to 7: save the table as CSV, \"writetable(T, 'file.csv')\""},
    {"MDF     ", "MDF, of vehicles' measurements: convert it to CSV, with asammdf \"mdf.export('csv')\""},
    {"TDSm", "TDMS of LabVIEW: convert it to CSV, with npTDMS \"tdmsinfo\" and \"as_dataframe().to_csv()\""},
    {"PAR1", "Parquet: convert it to CSV, with pandas \"read_parquet('FILE').to_csv('file.csv')\""},
    {std::string_view("ARROW1", 6),
     "Arrow: convert it to CSV, with pandas \"read_feather('FILE').to_csv('file.csv')\""},
    {std::string_view("SQLite format 3\0", 16),
     "an SQLite file; a record of gyrotherm needs no import, of another one export the table as CSV"},
    {"%PDF", "a PDF: ask for the table itself, as CSV"},
    {"#ROSBAG", "a ROS bag: export the topic as CSV, \"rostopic echo -b FILE -p TOPIC\""},
}};

}  // namespace

std::string way_out_of_format(std::string_view beginning) {
  if (beginning.starts_with(kZip)) {
    const bool is_workbook = beginning.find("[Content_Types].xml") != std::string_view::npos ||
                             beginning.find("xl/") != std::string_view::npos ||
                             beginning.find("_rels/.rels") != std::string_view::npos;
    return is_workbook ? "a workbook of Excel (xlsx): save the sheet as CSV, \"soffice --convert-to csv FILE\""
                       : "a zip archive: unpack it first, \"unzip FILE\"";
  }
  for (const KnownFormat& known : kKnown)
    if (beginning.starts_with(known.beginning)) return std::string(known.way_out);
  if (beginning.size() >= 262 && beginning.substr(257).starts_with("ustar"))
    return "a tar archive: unpack it first, \"tar -xf FILE\"";
  return "";
}

}  // namespace gyrotherm::exchange
