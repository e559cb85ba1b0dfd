// SPDX-License-Identifier: Apache-2.0
#include "tests/report/signing_keys.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "core/file.hpp"
#include "report/other_program.hpp"

namespace gyrotherm::report {

void run(const std::string& program, const std::vector<std::string>& words) {
  const auto ran = run_program(program, words);
  ASSERT_TRUE(ran) << text(ran.error());
  ASSERT_EQ(ran->exit_code, 0) << program << ": " << ran->out;
}

std::string pdf_of(const std::string& first, const std::string& second, bool has_field) {
  const auto stream = [](const std::string& content) {
    const std::string drawn = fmt::format("BT /F 12 Tf 72 720 Td ({}) Tj ET", content);
    return fmt::format("<< /Length {} >>\nstream\n{}\nendstream", drawn.size(), drawn);
  };
  const auto page = [](int contents) {
    return fmt::format(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 595 842] /Resources << /Font << /F 7 0 R >> >> /Contents {} 0 R "
        ">>",
        contents);
  };
  std::vector<std::string> objects{"<< /Type /Catalog /Pages 2 0 R >>",
                                   "<< /Type /Pages /Kids [3 0 R 4 0 R] /Count 2 >>",
                                   page(5),
                                   page(6),
                                   stream(first),
                                   stream(second),
                                   "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  if (has_field) {
    objects[0] = "<< /Type /Catalog /Pages 2 0 R /AcroForm << /Fields [8 0 R] /SigFlags 1 >> >>";
    objects[3].insert(3, "/Annots [8 0 R] ");
    objects.push_back("<< /Type /Annot /Subtype /Widget /FT /Sig /T (Signature) /Rect [0 0 0 0] /F 132 /P 4 0 R >>");
  }
  std::string pdf = "%PDF-1.6\n", table = "0000000000 65535 f \n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  return pdf + fmt::format("xref\n0 {}\n{}trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n",
                           objects.size() + 1, table, objects.size() + 1, pdf.size());
}

Keys::Keys() {
  authority("ca");
  authority("other-ca");
  issue("lab", "ca", {"-days", "3650"});
  issue("colleague", "ca", {"-days", "3650"});
  issue("brief", "ca", {"-days", "1"});
  issue("stranger", "other-ca", {"-days", "3650"});
  run("openssl",
      {"pkey", "-in", folder_ / "lab.key", "-aes256", "-passout", "pass:a secret", "-out", folder_ / "locked.key"});
  write("password", "a secret\n");
  write("wrong-password", "another\n");
}

SigningKey Keys::key(const std::string& name) const {
  return {.key_file = folder_ / (name + ".key"), .certificate_file = folder_ / (name + ".pem")};
}

void Keys::issue_with(const std::string& name, const std::string& extensions) {
  issue(name, "ca", {"-days", "3650"}, extensions);
}

void Keys::write(const std::string& name, const std::string& bytes) { (void)replace_text_file(folder_ / name, bytes); }

void Keys::authority(const std::string& name) {
  run("openssl", {"req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", folder_ / (name + ".key"), "-out",
                  folder_ / (name + ".pem"), "-days", "3650", "-subj", "/CN=" + name});
}

void Keys::issue(const std::string& name, const std::string& by, const std::vector<std::string>& more,
                 const std::string& extensions) {
  write("extensions", extensions);
  run("openssl", {"req", "-newkey", "rsa:2048", "-nodes", "-keyout", folder_ / (name + ".key"), "-out",
                  folder_ / "request", "-subj", "/C=DE/O=Inertial Laboratory/CN=" + name});
  std::vector<std::string> words{"x509",
                                 "-req",
                                 "-in",
                                 folder_ / "request",
                                 "-CA",
                                 folder_ / (by + ".pem"),
                                 "-CAkey",
                                 folder_ / (by + ".key"),
                                 "-CAcreateserial",
                                 "-extfile",
                                 folder_ / "extensions",
                                 "-out",
                                 folder_ / (name + ".pem")};
  words.insert(words.end(), more.begin(), more.end());
  run("openssl", words);
}

std::string Keys::issue_again(const std::string& folder, const std::vector<std::string>& options) const {
  std::filesystem::create_directory(folder);
  EXPECT_TRUE(replace_text_file(folder + "/index.txt", ""));
  EXPECT_TRUE(replace_text_file(folder + "/serial", "01\n"));
  EXPECT_TRUE(replace_text_file(
      folder + "/ca.cnf",
      fmt::format("[ca]\ndefault_ca=d\n[d]\ndatabase={0}/index.txt\nnew_certs_dir={0}\nserial={0}/serial\n"
                  "default_md=sha256\npolicy=p\n[p]\ncommonName=supplied\n[e]\n{1}",
                  folder, kForSigning)));
  const std::string request = folder + "/request", certificate = folder + "/again.pem";
  run("openssl", {"req", "-new", "-key", *this / "lab.key", "-out", request, "-subj", "/CN=lab"});
  std::vector<std::string> arguments{"ca", "-batch", "-config", folder + "/ca.cnf", "-extensions", "e", "-in", request};
  arguments.insert(arguments.end(), {"-cert", *this / "ca.pem", "-keyfile", *this / "ca.key", "-notext", "-out"});
  arguments.push_back(certificate);
  arguments.insert(arguments.end(), options.begin(), options.end());
  run("openssl", arguments);
  return certificate;
}

std::string utc_text(std::time_t at, const char* form) {
  std::tm time{};
  ::gmtime_r(&at, &time);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), form, &time)};
}

}  // namespace gyrotherm::report
