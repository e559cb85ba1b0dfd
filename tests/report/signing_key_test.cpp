// SPDX-License-Identifier: Apache-2.0
/// Keys and certificates that cannot sign are refused before a report is rendered.
#include <gtest/gtest.h>

#include <string>

#include "report/signature.hpp"
#include "tests/report/signing_keys.hpp"

namespace gyrotherm::report {
namespace {

TEST(SigningKey, RefusesKeyForOtherPadding) {
  const Keys keys;
  const std::string key = keys / "pss.key", certificate = keys / "pss.pem";
  run("openssl", {"req", "-x509", "-newkey", "rsa-pss", "-pkeyopt", "rsa_keygen_bits:2048", "-nodes", "-keyout", key,
                  "-out", certificate, "-days", "30", "-subj", "/CN=pss", "-addext",
                  "basicConstraints=critical,CA:FALSE", "-addext", "keyUsage=critical,digitalSignature"});
  const SigningKey padded{.key_file = key, .certificate_file = certificate};
  const SigningKey other{.key_file = key, .certificate_file = keys.key("lab").certificate_file};
  for (const SigningKey& one : {padded, other}) {
    const auto refused = check_signing_key_without_prompt(one);
    ASSERT_FALSE(refused);
    EXPECT_EQ(text(refused.error()), key + ": is an RSA-PSS key, expected rsaEncryption");
  }
  SigningKey locked = padded;
  locked.key_file = keys / "locked.key";
  const auto refused = check_signing_key_without_prompt(locked);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().where, certificate);
}

TEST(SigningKey, RequiresPlainCertificateOfSigner) {
  const Keys keys;
  SigningKey key = keys.key("lab");
  const std::string trusted = keys / "trusted.pem";
  run("openssl", {"x509", "-in", key.certificate_file, "-trustout", "-out", trusted});
  key.certificate_file = trusted;
  const auto refused = check_signing_key(key);
  ASSERT_FALSE(refused);
  EXPECT_EQ(text(refused.error()), trusted + ": contains \"TRUSTED CERTIFICATE\", expected a certificate in PEM");
  EXPECT_TRUE(check_trusted_file(trusted));
}

}  // namespace
}  // namespace gyrotherm::report
