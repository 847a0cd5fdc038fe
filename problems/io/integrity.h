// What a page's content policy calls a script by.
#pragma once

#include <string>
#include <string_view>

namespace sagitta {

// "sha256-…" in base64, as in W3C Subresource Integrity, section 3.1.
std::string IntegrityDigest(std::string_view bytes);

}  // namespace sagitta
