// SPDX-License-Identifier: Apache-2.0
#include "tests/report/signing_keys.hpp"

#include <gtest/gtest.h>

#include "core/file.hpp"
#include "report/other_program.hpp"

namespace gyrotherm::report {

void run(const std::string& program, const std::vector<std::string>& words) {
  const auto ran = run_program(program, words);
  ASSERT_TRUE(ran) << text(ran.error());
  ASSERT_EQ(ran->exit_code, 0) << program << ": " << ran->out;
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

}  // namespace gyrotherm::report
