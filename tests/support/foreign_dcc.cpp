// SPDX-License-Identifier: Apache-2.0
#include "tests/support/foreign_dcc.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/file.hpp"
#include "report/other_program.hpp"

namespace gyrotherm::report {
namespace {

constexpr const char* kRootEnd = "</dcc:digitalCalibrationCertificate>";

void run_tool(const std::string& program, const std::vector<std::string>& words) {
  const auto ran = run_program(program, words);
  ASSERT_TRUE(ran) << text(ran.error());
  ASSERT_EQ(ran->exit_code, 0) << program << ": " << ran->out;
}

}  // namespace

std::string foreign_dcc() {
  return R"(<?xml version="1.0" encoding="utf-8" standalone="no"?>
<dcc:digitalCalibrationCertificate xmlns:dcc="https://ptb.de/dcc" xmlns:si="https://ptb.de/si" schemaVersion="3.2.0">
  <!-- an invented certificate -->
  <dcc:administrativeData>
    <dcc:coreData>
      <dcc:uniqueIdentifier>THERMO-2025-0417</dcc:uniqueIdentifier>
      <dcc:beginPerformanceDate>2025-11-03</dcc:beginPerformanceDate>
      <dcc:endPerformanceDate>2025-11-04</dcc:endPerformanceDate>
      <dcc:performanceLocation>laboratory</dcc:performanceLocation>
    </dcc:coreData>
    <dcc:items>
      <dcc:item id="probe">
        <dcc:name><dcc:content lang="en">Temperature sensor</dcc:content></dcc:name>
        <dcc:identifications>
          <dcc:identification><dcc:issuer>manufacturer</dcc:issuer><dcc:value> T-0417 </dcc:value></dcc:identification>
        </dcc:identifications>
      </dcc:item>
    </dcc:items>
    <dcc:calibrationLaboratory>
      <dcc:contact><dcc:name><dcc:content>Thermo Lab</dcc:content></dcc:name></dcc:contact>
    </dcc:calibrationLaboratory>
    <dcc:statements>
      <dcc:statement refType="basic_recalibration"><dcc:date>2026-11-04</dcc:date></dcc:statement>
    </dcc:statements>
  </dcc:administrativeData>
  <dcc:measurementResults>
    <dcc:measurementResult>
      <dcc:results>
        <dcc:result refType="gp_measuringResult1">
          <dcc:data>
            <dcc:list refType="gp_table1">
              <dcc:quantity refType="basic_referenceValue">
                <si:hybrid>
                  <si:realListXMLList>
                    <si:valueXMLList>233.15 258.15 283.15 308.15 333.15</si:valueXMLList>
                    <si:unitXMLList>\kelvin</si:unitXMLList>
                  </si:realListXMLList>
                  <si:realListXMLList>
                    <si:valueXMLList>-40 -15 10 35 60</si:valueXMLList>
                    <si:unitXMLList>\degreecelsius</si:unitXMLList>
                  </si:realListXMLList>
                </si:hybrid>
              </dcc:quantity>
              <dcc:quantity refType="basic_measuredValue">
                <si:realListXMLList>
                  <si:valueXMLList>-39.98 -14.99 10.0 34.99 59.98</si:valueXMLList>
                  <si:unitXMLList>\degreecelsius</si:unitXMLList>
                </si:realListXMLList>
              </dcc:quantity>
              <dcc:quantity refType="basic_measurementError">
                <si:realListXMLList>
                  <si:valueXMLList>20 10 0 -10 -20</si:valueXMLList>
                  <si:unitXMLList>\milli\kelvin</si:unitXMLList>
                  <si:expandedUncXMLList>
                    <si:uncertaintyXMLList>21</si:uncertaintyXMLList>
                    <si:coverageFactorXMLList>2</si:coverageFactorXMLList>
                    <si:coverageProbabilityXMLList>0.95</si:coverageProbabilityXMLList>
                    <si:distributionXMLList>normal</si:distributionXMLList>
                  </si:expandedUncXMLList>
                </si:realListXMLList>
              </dcc:quantity>
            </dcc:list>
          </dcc:data>
        </dcc:result>
      </dcc:results>
    </dcc:measurementResult>
  </dcc:measurementResults>
</dcc:digitalCalibrationCertificate>
)";
}

std::string with_replaced(std::string text, const std::string& what, const std::string& with) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  if (at == std::string::npos) return text;
  EXPECT_EQ(text.find(what, at + 1), std::string::npos) << what << " occurs twice";
  return text.replace(at, what.size(), with);
}

ForeignKeys::ForeignKeys() {
  for (const std::string name : {"authority", "other-authority"})
    run_tool("openssl", {"req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", folder_ / (name + ".key"), "-out",
                         folder_ / (name + ".pem"), "-days", "3650", "-subj", "/CN=" + name});
  issue("laboratory", "authority", "rsa:2048", "3650");
  issue("stranger", "other-authority", "rsa:2048", "3650");
}

void ForeignKeys::issue(const std::string& name, const std::string& authority, const std::string& algorithm,
                        const std::string& days) {
  ASSERT_TRUE(replace_text_file(folder_ / "extensions",
                                "basicConstraints=critical,CA:FALSE\n"
                                "keyUsage=critical,digitalSignature,nonRepudiation\n"));
  std::vector<std::string> request{"req",     "-newkey",
                                   algorithm, "-nodes",
                                   "-keyout", folder_ / (name + ".key"),
                                   "-out",    folder_ / "request",
                                   "-subj",   "/O=Thermo Lab/CN=" + name};
  if (algorithm == "ec") request.insert(request.end(), {"-pkeyopt", "ec_paramgen_curve:P-256"});
  run_tool("openssl", request);
  run_tool("openssl", {"x509", "-req", "-in", folder_ / "request", "-CA", folder_ / (authority + ".pem"), "-CAkey",
                       folder_ / (authority + ".key"), "-CAcreateserial", "-extfile", folder_ / "extensions", "-days",
                       days, "-out", folder_ / (name + ".pem")});
}

std::string ForeignKeys::certificate(const std::string& name) const {
  const std::string pem = read_text_file(folder_ / (name + ".pem")).value_or("");
  const std::string begin = "-----BEGIN CERTIFICATE-----";
  const auto from = pem.find(begin) + begin.size();
  return pem.substr(from, pem.find("-----END") - from);  // with line ends, as other programs write it
}

std::string signature_template(const std::string& method, const std::string& certificate) {
  const std::string space = "http://www.w3.org/2000/09/xmldsig#", more = "http://www.w3.org/2001/04/xmldsig-more#";
  return fmt::format(R"(<ds:Signature xmlns:ds="{0}">
<ds:SignedInfo>
<ds:CanonicalizationMethod Algorithm="http://www.w3.org/2001/10/xml-exc-c14n#"/>
<ds:SignatureMethod Algorithm="{1}"/>
<ds:Reference URI="">
<ds:Transforms><ds:Transform Algorithm="{0}enveloped-signature"/>
<ds:Transform Algorithm="http://www.w3.org/2006/12/xml-c14n11"/></ds:Transforms>
<ds:DigestMethod Algorithm="http://www.w3.org/2001/04/xmlenc#sha256"/><ds:DigestValue/>
</ds:Reference>
</ds:SignedInfo>
<ds:SignatureValue/>
<ds:KeyInfo><ds:X509Data><ds:X509Certificate>{2}</ds:X509Certificate></ds:X509Data></ds:KeyInfo>
</ds:Signature>)",
                     space, method == "rsa-sha1" ? space + method : more + method, certificate);
}

std::string ForeignKeys::sign_template(const std::string& document, const std::string& name) const {
  EXPECT_TRUE(replace_text_file(folder_ / "in.xml", document));
  const auto ran = run_program("xmlsec1", {"--sign", "--privkey-pem", folder_ / (name + ".key"), "--enabled-key-data",
                                           "key-name", "--output", folder_ / "out.xml", folder_ / "in.xml"});
  EXPECT_TRUE(ran && ran->exit_code == 0) << (ran ? ran->out : text(ran.error()));
  return read_text_file(folder_ / "out.xml", kLargestTable).value_or("");
}

std::string ForeignKeys::sign(const std::string& dcc, const std::string& name, const std::string& method) const {
  return sign_template(with_replaced(dcc, kRootEnd, signature_template(method, certificate(name)) + kRootEnd), name);
}

}  // namespace gyrotherm::report
