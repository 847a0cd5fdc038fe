#include "tools/report/report_html.h"

#include <algorithm>

#include "problems/io/integrity.h"
#include "tools/report/html_text.h"
#include "tools/report/page_parts.h"

namespace sagitta {
namespace {

// Paragraphs; those that begin with "- " are the items of lists, as on the terminal.
std::string ParagraphsToHtml(const std::vector<std::string>& paragraphs, bool first_is_verdict) {
  std::string html;
  bool in_list = false;
  for (size_t i = 0; i < paragraphs.size(); ++i) {
    const bool is_item = paragraphs[i].rfind("- ", 0) == 0;
    if (is_item != in_list) html += is_item ? "<ul>\n" : "</ul>\n";
    in_list = is_item;
    const std::string text = EscapeHtml(is_item ? paragraphs[i].substr(2) : paragraphs[i]);
    if (is_item) {
      html += "<li>" + text + "</li>\n";
    } else {
      html += (i == 0 && first_is_verdict ? "<p class=\"verdict\">" : "<p>") + text + "</p>\n";
    }
  }
  return html + (in_list ? "</ul>\n" : "");
}

std::string SectionToHtml(const Section& section, bool is_first) {
  const std::string heading = is_first ? "h1" : "h2";
  const std::string title = "<" + heading + ">" + EscapeHtml(section.title) + "</" + heading + ">";
  std::string html = section.folded ? "<details><summary>" + title + "</summary>\n" : title + "\n";
  if (!section.header.empty()) html += TableToHtml(section.header, section.rows);
  html += ParagraphsToHtml(section.paragraphs, is_first);
  for (const Picture& picture : section.pictures) html += PictureToHtml(picture);
  return html + (section.folded ? "</details>\n" : "");
}

std::string ProvenanceToHtml(const Provenance& provenance) {
  std::string html = "<h2>Provenance</h2>\n<p>sagitta " SAGITTA_VERSION ", method " + EscapeHtml(provenance.method) +
                     ", run " + RunId(provenance) + "</p>\n<p><code>" + EscapeHtml(provenance.command) +
                     "</code></p>\n<div class=\"table\"><table><tbody>\n";
  for (const InputFile& input : provenance.inputs) {
    html +=
        "<tr><td>" + EscapeHtml(input.path) + "</td><td class=\"unit\"><code>" + input.sha256 + "</code></td></tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

// The scripts that draw the pictures; of the libraries those that they need.
std::vector<std::string_view> ScriptsFor(const std::vector<const Picture*>& pictures) {
  if (pictures.empty() || !HasPictures()) return {};
  const bool any_in_space = std::any_of(pictures.begin(), pictures.end(),
                                        [](const Picture* picture) { return picture->kind == "workspace"; });
  if (any_in_space) return {page::kVega, page::kThree, page::kDrawing};
  return {page::kVega, page::kDrawing};
}

// Nothing from anywhere, and no script but those that stand here.
std::string PolicyFor(const std::vector<std::string_view>& scripts) {
  std::string sources;
  for (const std::string_view script : scripts) sources += " '" + IntegrityDigest(script) + "'";
  return "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
         "img-src data: blob:; script-src" +
         (sources.empty() ? " 'none'" : sources) + "\">";
}

std::string ScriptsToHtml(const std::vector<std::string_view>& scripts) {
  if (scripts.empty()) return "";
  std::string html =
      "<script type=\"application/json\" id=\"templates\">" + std::string(page::kTemplates) + "</script>\n";
  for (const std::string_view script : scripts) html += "<script>" + std::string(script) + "</script>\n";
  return html;
}

}  // namespace

std::string PageAround(const std::string& title, const std::string& style, const std::string& body,
                       const std::vector<const Picture*>& pictures) {
  const std::vector<std::string_view> scripts = ScriptsFor(pictures);
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">" + PolicyFor(scripts) +
         "\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>" + EscapeHtml(title) +
         " - sagitta</title>\n<style>" + std::string(page::kStyle) + style + "</style></head><body>\n" + body +
         ScriptsToHtml(scripts) + "</body></html>\n";
}

std::string SectionsToPage(const std::vector<Section>& sections, const Provenance& provenance) {
  std::string body;
  std::vector<const Picture*> pictures;
  for (size_t i = 0; i < sections.size(); ++i) {
    body += SectionToHtml(sections[i], i == 0);
    for (const Picture& picture : sections[i].pictures) pictures.push_back(&picture);
  }
  return PageAround(sections.front().title, "", body + ProvenanceToHtml(provenance), pictures);
}

}  // namespace sagitta
