// SPDX-License-Identifier: Apache-2.0
#include "report/xml_signature.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/text.hpp"
#include "report/xml_text.hpp"

namespace gyrotherm::report {
namespace {

constexpr std::string_view kSignatureSpace = "http://www.w3.org/2000/09/xmldsig#";
constexpr std::string_view kEnveloped = "http://www.w3.org/2000/09/xmldsig#enveloped-signature";
constexpr std::string_view kSignedProperties = "http://uri.etsi.org/01903#SignedProperties";
constexpr std::array<std::string_view, 3> kCanonicalForms{"http://www.w3.org/TR/2001/REC-xml-c14n-20010315",
                                                          "http://www.w3.org/2006/12/xml-c14n11",
                                                          "http://www.w3.org/2001/10/xml-exc-c14n#"};
constexpr std::array<std::string_view, 3> kDigests{"http://www.w3.org/2001/04/xmlenc#sha256",
                                                   "http://www.w3.org/2001/04/xmldsig-more#sha384",
                                                   "http://www.w3.org/2001/04/xmlenc#sha512"};
constexpr std::array<std::string_view, 6> kMethods{
    "http://www.w3.org/2001/04/xmldsig-more#rsa-sha256",   "http://www.w3.org/2001/04/xmldsig-more#rsa-sha384",
    "http://www.w3.org/2001/04/xmldsig-more#rsa-sha512",   "http://www.w3.org/2001/04/xmldsig-more#ecdsa-sha256",
    "http://www.w3.org/2001/04/xmldsig-more#ecdsa-sha384", "http://www.w3.org/2001/04/xmldsig-more#ecdsa-sha512"};
constexpr std::size_t kMostSigners = 8;

bool is_one_of(const auto& permitted, std::string_view algorithm) {
  return std::ranges::find(permitted, algorithm) != permitted.end();
}

std::string_view algorithm_of(const XmlElement* element) {
  return element == nullptr ? std::string_view() : element->attribute("Algorithm");
}

class SignatureForm {
 public:
  SignatureForm(const XmlElement& root, std::string file) : root_(root), file_(std::move(file)) {}

  Result<XmlSignature> check() const {
    const int count = count_signatures(root_);
    if (count == 0) return refused(root_, "is not signed");
    if (count > 1) return refused(root_, fmt::format("has {} signatures, expected 1", count));
    const auto at = std::ranges::find_if(root_.children, is_signature);
    if (at == root_.children.end()) return refused(root_, "has a signature that does not cover the whole certificate");
    if (auto done = check_signed_info(*at); !done) return failure(done.error());
    XmlSignature signature{.line = at->line, .certificates = list_certificates(*at)};
    const auto& all = signature.certificates;
    if (all.empty() || all.size() > kMostSigners ||
        !std::ranges::all_of(all, [](const auto& one) { return is_base64(one); }))
      return refused(*at, fmt::format("its signature has {} certificates, expected 1 to {}", all.size(), kMostSigners));
    return signature;
  }

 private:
  static bool is_signature(const XmlElement& element) { return element.is(kSignatureSpace, "Signature"); }

  static int count_signatures(const XmlElement& element) {
    int count = is_signature(element) ? 1 : 0;
    for (const XmlElement& child : element.children) count += count_signatures(child);
    return count;
  }

  tl::unexpected<Fault> refused(const XmlElement& at, std::string what) const {
    return failure(FaultKind::bad_file, fmt::format("{}:{}", file_, at.line), std::move(what));
  }

  Result<void> check_signed_info(const XmlElement& signature) const {
    const XmlElement* info = signature.only("SignedInfo");
    if (info == nullptr) return refused(signature, "its signature does not state what it covers");
    if (const auto form = algorithm_of(info->only("CanonicalizationMethod")); !is_one_of(kCanonicalForms, form))
      return refused(*info, fmt::format("its signature uses the canonical form \"{}\"", plain(form)));
    if (const auto method = algorithm_of(info->only("SignatureMethod")); !is_one_of(kMethods, method))
      return refused(*info, fmt::format("its signature uses the method \"{}\", expected RSA or ECDSA with SHA-256 or "
                                        "longer",
                                        plain(method)));
    int whole = 0;
    for (const XmlElement* reference : info->all("Reference")) {
      if (auto done = check_reference(*reference); !done) return done;
      if (covers_document(*reference)) ++whole;
    }
    if (whole != 1) return refused(*info, "its signature does not cover the whole certificate");
    return {};
  }

  static bool covers_document(const XmlElement& reference) {
    const auto is_uri = [](const auto& attribute) { return attribute.first == "URI"; };
    return std::ranges::any_of(reference.attributes, is_uri) && reference.attribute("URI").empty();
  }

  Result<void> check_reference(const XmlElement& reference) const {
    if (const auto digest = algorithm_of(reference.only("DigestMethod")); !is_one_of(kDigests, digest))
      return refused(reference,
                     fmt::format("its signature uses the digest \"{}\", expected SHA-256 or longer", plain(digest)));
    const bool is_whole = covers_document(reference);
    if (!is_whole && !(reference.attribute("Type") == kSignedProperties && reference.attribute("URI").starts_with('#')))
      return refused(reference, "its signature covers other parts than the whole certificate");
    int enveloped = 0;
    if (const XmlElement* transforms = reference.only("Transforms"))
      for (const XmlElement* one : transforms->all("Transform")) {
        const auto algorithm = algorithm_of(one);
        enveloped += algorithm == kEnveloped ? 1 : 0;
        if (algorithm != kEnveloped && !is_one_of(kCanonicalForms, algorithm))
          return refused(*one, fmt::format("its signature uses the transform \"{}\"", plain(algorithm)));
      }
    if (is_whole && enveloped != 1) return refused(reference, "its signature is not enveloped");
    return {};
  }

  static std::vector<std::string> list_certificates(const XmlElement& signature) {
    std::vector<std::string> found;
    const XmlElement* info = signature.only("KeyInfo");
    if (info == nullptr) return found;
    for (const XmlElement* data : info->all("X509Data"))
      for (const XmlElement* certificate : data->all("X509Certificate")) {
        found.push_back(certificate->text);
        std::erase_if(found.back(), [](char c) { return c == '\n' || c == '\r' || c == ' ' || c == '\t'; });
      }
    return found;
  }

  const XmlElement& root_;
  std::string file_;
};

}  // namespace

Result<XmlSignature> find_whole_signature(const XmlElement& root, const std::string& file) {
  return SignatureForm(root, file).check();
}

}  // namespace gyrotherm::report
