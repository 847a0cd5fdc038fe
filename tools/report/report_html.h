// report.html: one self-contained page for people. It needs no network and asks for none: style, scripts and data are
// in it, and its content policy forbids everything else.
#pragma once

#include <string>
#include <vector>

#include "estimator/results/provenance.h"
#include "tools/report/summary.h"

namespace sagitta {

// The frame of a page: `style` is added to that of all pages; the scripts are those that the pictures in `body` need.
std::string PageAround(const std::string& title, const std::string& style, const std::string& body,
                       const std::vector<const Picture*>& pictures);

// A page of sections: the title of the first one is its heading, the first paragraph its verdict.
std::string SectionsToPage(const std::vector<Section>& sections, const Provenance& provenance);

}  // namespace sagitta
