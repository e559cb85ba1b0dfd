// SPDX-License-Identifier: Apache-2.0
#include "apps/pdf/pdf_file.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <QString>
#include <algorithm>
#include <charconv>
#include <ctime>
#include <iterator>
#include <utility>

#include "core/sha256.hpp"
#include "report/plot/svg.hpp"

namespace gyrotherm::report {
namespace {

tl::unexpected<Fault> unknown_build(const char* what) {
  return failure(FaultKind::corrupted, "the PDF that Qt made", fmt::format("it has no {} where one is expected", what));
}

/// The number that stands directly after a word, looked for from a place on.
std::optional<std::size_t> number_after(std::string_view text, std::string_view word, std::size_t from = 0) {
  auto at = text.find(word, from);
  if (at == std::string_view::npos) return std::nullopt;
  at = text.find_first_not_of(" \n", at + word.size());
  if (at == std::string_view::npos) return std::nullopt;
  std::size_t number{};
  const auto read = std::from_chars(text.data() + at, text.data() + text.size(), number);
  return read.ec == std::errc{} ? std::optional(number) : std::nullopt;
}

/// The number of an object, of as many as there are, that a key leads to.
std::optional<std::size_t> object_after(std::string_view text, std::string_view key, std::size_t objects,
                                        std::size_t from = 0) {
  const auto number = number_after(text, key, from);
  return number && *number > 0 && *number <= objects ? number : std::nullopt;
}

/// A file, taken apart.
struct PdfObjects {
  std::string head;                  ///< the lines before the first object
  std::vector<std::string> objects;  ///< whole ones, "1 0 obj … endobj\n", the first at 0
  std::size_t info{}, root{};        ///< their numbers, from 1
};

/// Cuts the file at the places that its table names.
Result<PdfObjects> taken_apart(std::string_view pdf) {
  const auto table = number_after(pdf, "startxref", pdf.size() - std::min<std::size_t>(pdf.size(), 64));
  if (!table || *table >= pdf.size() || !pdf.substr(*table).starts_with("xref\n0 ")) return unknown_build("xref table");
  const auto size = number_after(pdf, "xref\n0 ", *table);
  if (!size || *size < 2 || *size > pdf.size()) return unknown_build("number of objects");
  const auto info = object_after(pdf, "/Info ", *size - 1, *table);
  const auto root = object_after(pdf, "/Root ", *size - 1, *table);
  if (!info || !root) return unknown_build("trailer");
  const auto rows = pdf.find('\n', *table + 5) + 1;
  constexpr std::size_t kRow = 20;
  if (rows + *size * kRow > pdf.size()) return unknown_build("whole xref table");
  std::vector<std::pair<std::size_t, std::size_t>> places;  // and numbers
  for (std::size_t number = 1; number < *size; ++number) {
    std::size_t place{};
    const char* row = pdf.data() + rows + number * kRow;
    std::from_chars(row, row + 10, place);
    if (!pdf.substr(std::min(place, pdf.size())).starts_with(fmt::format("{} 0 obj", number)))
      return unknown_build("object");
    places.emplace_back(place, number);
  }
  std::ranges::sort(places);
  PdfObjects parts{
      .head = std::string(pdf.substr(0, places.front().first)), .objects = {}, .info = *info, .root = *root};
  parts.objects.resize(places.size());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const auto end = k + 1 < places.size() ? places[k + 1].first : *table;
    parts.objects[places[k].second - 1] = pdf.substr(places[k].first, end - places[k].first);
  }
  return parts;
}

/// Text of any script as a PDF has it: UTF-16, most significant byte first, in hexadecimal.
std::string pdf_text(const std::string& text) {
  std::string coded = "<FEFF";
  for (const QChar unit : QString::fromStdString(text))
    fmt::format_to(std::back_inserter(coded), "{:04X}", unsigned{unit.unicode()});
  return coded + ">";
}

std::tm utc_of(std::int64_t utc_s) { return fmt::gmtime(static_cast<std::time_t>(utc_s)); }

std::string info_of(const PdfFacts& facts) {
  std::string dates;
  if (facts.utc_s) {
    const auto day = fmt::format("(D:{:%Y%m%d%H%M%S}+00'00')", utc_of(*facts.utc_s));
    dates = fmt::format("/CreationDate {}\n/ModDate {}\n", day, day);
  }
  return fmt::format("<<\n/Title {}\n/Author {}\n/Keywords {}\n/Creator {}\n/Producer {}\n{}>>\n",
                     pdf_text(facts.title), pdf_text(facts.author), pdf_text(facts.keywords), pdf_text(facts.creator),
                     pdf_text(facts.producer), dates);
}

constexpr const char* kXmp =
    "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
    "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
    "<rdf:Description rdf:about=\"\" xmlns:dc=\"http://purl.org/dc/elements/1.1/\" "
    "xmlns:pdf=\"http://ns.adobe.com/pdf/1.3/\" xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\" "
    "xmlns:pdfaid=\"http://www.aiim.org/pdfa/ns/id/\">\n"
    "<dc:format>application/pdf</dc:format>\n"
    "<dc:title><rdf:Alt><rdf:li xml:lang=\"x-default\">{}</rdf:li></rdf:Alt></dc:title>\n"
    "<dc:creator><rdf:Seq><rdf:li>{}</rdf:li></rdf:Seq></dc:creator>\n"
    "<dc:language><rdf:Bag><rdf:li>{}</rdf:li></rdf:Bag></dc:language>\n"
    "<pdf:Keywords>{}</pdf:Keywords>\n<pdf:Producer>{}</pdf:Producer>\n<xmp:CreatorTool>{}</xmp:CreatorTool>\n{}"
    "<pdfaid:part>1</pdfaid:part>\n<pdfaid:conformance>B</pdfaid:conformance>\n"
    "</rdf:Description>\n</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"r\"?>\n";

/// The same facts once more, as PDF/A asks for them.
std::string metadata_of(const PdfFacts& facts) {
  std::string dates;
  if (facts.utc_s) {
    const auto day = fmt::format("{:%Y-%m-%dT%H:%M:%S}+00:00", utc_of(*facts.utc_s));
    dates = fmt::format("<xmp:CreateDate>{}</xmp:CreateDate>\n<xmp:ModifyDate>{}</xmp:ModifyDate>\n", day, day);
  }
  const auto xmp = fmt::format(fmt::runtime(kXmp), plot::escaped(facts.title), plot::escaped(facts.author),
                               plot::escaped(facts.language), plot::escaped(facts.keywords),
                               plot::escaped(facts.producer), plot::escaped(facts.creator), dates);
  return fmt::format("<<\n/Type /Metadata\n/Subtype /XML\n/Length {}\n>>\nstream\n{}\nendstream\n", xmp.size(), xmp);
}

/// The numbers of the objects that are pages, in their order.
Result<std::vector<std::size_t>> pages_of(const PdfObjects& parts) {
  const auto tree = object_after(parts.objects[parts.root - 1], "/Pages ", parts.objects.size());
  if (!tree) return unknown_build("page tree");
  const std::string& text = parts.objects[*tree - 1];
  const auto kids = text.find("/Kids");
  if (kids == std::string::npos) return unknown_build("list of pages");
  const auto list = text.substr(kids, text.find(']', kids) - kids);
  std::vector<std::size_t> pages;
  for (std::size_t at = list.find_first_of("0123456789"); at != std::string::npos;) {
    const auto number = object_after(list, "", parts.objects.size(), at);
    if (!number) return unknown_build("page");
    pages.push_back(*number);
    at = list.find_first_of("0123456789", list.find('R', at));
  }
  return pages;
}

constexpr std::size_t kNobody = static_cast<std::size_t>(-1);

/// A bookmark's neighbours in the tree that a PDF makes of them.
struct Branch {
  std::size_t parent = kNobody, before = kNobody, after = kNobody, first = kNobody, last = kNobody, below = 0;
};

/// The last branch is the trunk.
std::vector<Branch> branches_of(const std::vector<Bookmark>& bookmarks) {
  const std::size_t trunk = bookmarks.size();
  std::vector<Branch> branches(trunk + 1);
  std::size_t top = trunk;
  for (std::size_t i = 0; i < bookmarks.size(); ++i) {
    const std::size_t parent = bookmarks[i].sub ? top : trunk;
    Branch& above = branches[parent];
    branches[i].parent = parent;
    branches[i].before = above.last;
    if (above.last != kNobody) branches[above.last].after = i;
    if (above.first == kNobody) above.first = i;
    above.last = i;
    ++above.below;
    if (!bookmarks[i].sub) top = i;
  }
  return branches;
}

/// Appends the table of contents; returns the number of its trunk.
Result<std::size_t> add_contents(PdfObjects& parts, const PdfFacts& facts, double page_height_pt) {
  const auto pages = pages_of(parts);
  if (!pages) return failure(pages.error());
  const auto branches = branches_of(facts.bookmarks);
  const auto number = [first = parts.objects.size() + 1](std::size_t branch) { return first + branch; };
  for (std::size_t i = 0; i < branches.size(); ++i) {
    const Branch& branch = branches[i];
    std::string text = fmt::format("{} 0 obj\n<<\n", number(i));
    const auto lead = [&](const char* key, std::size_t to) {
      if (to != kNobody) fmt::format_to(std::back_inserter(text), "/{} {} 0 R\n", key, number(to));
    };
    lead("Parent", branch.parent);
    lead("Prev", branch.before);
    lead("Next", branch.after);
    lead("First", branch.first);
    lead("Last", branch.last);
    if (i < facts.bookmarks.size()) {
      const Bookmark& bookmark = facts.bookmarks[i];
      if (bookmark.page >= pages->size()) return unknown_build("page that a bookmark leads to");
      if (branch.below > 0) text += fmt::format("/Count -{}\n", branch.below);  // closed until somebody opens it
      text += fmt::format("/Title {}\n/Dest [{} 0 R /XYZ 0 {:.1f} null]\n", pdf_text(bookmark.title),
                          (*pages)[bookmark.page], page_height_pt - bookmark.top_pt);
    } else {
      text += fmt::format("/Type /Outlines\n/Count {}\n", branch.below);
    }
    parts.objects.push_back(text + ">>\nendobj\n");
  }
  return number(facts.bookmarks.size());
}

/// Replaces an object by another body.
void replace(PdfObjects& parts, std::size_t number, const std::string& body) {
  parts.objects[number - 1] = fmt::format("{} 0 obj\n{}endobj\n", number, body);
}

/// Adds lines to the dictionary that an object is.
bool add_to(std::string& object, const std::string& lines) {
  const auto end = object.rfind(">>");
  if (end == std::string::npos) return false;
  object.insert(end, lines);
  return true;
}

/// Adds the field to the last page; returns its number.
Result<std::size_t> add_signature_field(PdfObjects& parts) {
  const auto pages = pages_of(parts);
  if (!pages) return failure(pages.error());
  if (pages->empty()) return unknown_build("page");
  const auto notes = object_after(parts.objects[pages->back() - 1], "/Annots ", parts.objects.size());
  if (!notes) return unknown_build("list of annotations");
  const std::size_t field = parts.objects.size() + 1;
  parts.objects.push_back(
      fmt::format("{} 0 obj\n<<\n/Type /Annot\n/Subtype /Widget\n/FT /Sig\n/T (Signature)\n/F 132\n/Rect [0 0 0 0]\n"
                  "/P {} 0 R\n/AP <</N {} 0 R>>\n>>\nendobj\n",
                  field, pages->back(), field + 1));
  parts.objects.push_back(
      fmt::format("{} 0 obj\n<<\n/Type /XObject\n/Subtype /Form\n/BBox [0 0 0 0]\n/Length 0\n>>\nstream\n\nendstream\n"
                  "endobj\n",
                  field + 1));
  std::string& list = parts.objects[*notes - 1];
  const auto end = list.rfind(']');
  if (end == std::string::npos) return unknown_build("list of annotations");
  list.insert(end, fmt::format(" {} 0 R ", field));
  return field;
}

std::string put_together(const PdfObjects& parts) {
  std::string pdf = parts.head, table;
  for (const std::string& object : parts.objects) {
    fmt::format_to(std::back_inserter(table), "{:010} 00000 n \n", pdf.size());
    pdf += object;
  }
  const auto id = sha256(pdf).substr(0, 32);
  const auto place = pdf.size(), size = parts.objects.size() + 1;
  fmt::format_to(std::back_inserter(pdf),
                 "xref\n0 {}\n0000000000 65535 f \n{}trailer\n<<\n/Size {}\n/Info {} 0 R\n/Root {} 0 R\n"
                 "/ID [<{}><{}>]\n>>\nstartxref\n{}\n%%EOF\n",
                 size, table, size, parts.info, parts.root, id, id, place);
  return pdf;
}

}  // namespace

Result<std::string> finished(std::string_view pdf, const PdfFacts& facts, double page_height_pt) {
  auto parts = taken_apart(pdf);
  if (!parts) return failure(parts.error());
  std::string more = fmt::format("/Lang ({})\n/ViewerPreferences <</DisplayDocTitle true>>\n", facts.language);
  if (!facts.bookmarks.empty()) {
    const auto trunk = add_contents(*parts, facts, page_height_pt);
    if (!trunk) return failure(trunk.error());
    more += fmt::format("/Outlines {} 0 R\n/PageMode /UseOutlines\n", *trunk);
  }
  if (facts.has_signature_field) {
    const auto field = add_signature_field(*parts);
    if (!field) return failure(field.error());
    more += fmt::format("/AcroForm <</Fields [{} 0 R] /SigFlags 1>>\n", *field);
  }
  std::string& root = parts->objects[parts->root - 1];
  const auto metadata = object_after(root, "/Metadata ", parts->objects.size());
  if (!metadata) return unknown_build("metadata");
  if (!add_to(root, more)) return unknown_build("catalogue");
  replace(*parts, *metadata, metadata_of(facts));
  replace(*parts, parts->info, info_of(facts));
  return put_together(*parts);
}

}  // namespace gyrotherm::report
