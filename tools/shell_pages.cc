#include "tools/shell_pages.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "problems/input_error.h"
#include "problems/io/output_files.h"
#include "tools/run_command.h"

namespace sagitta {
namespace {

struct FlagPage {
  std::string name;  // "--out=TEXT" without its value: "out"
  bool takes_value = true;
  std::string words;
};

struct CommandPage {
  std::string name, summary, usage, description;
  std::vector<FlagPage> flags;
};

std::string HelpOfProgram(const std::string& program) {
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string line = "'" + (own.parent_path() / program).string() + "' --help";
  std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(line.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 4096> part;
  while (pipe && std::fgets(part.data(), part.size(), pipe.get()) != nullptr) text += part.data();
  if (text.empty()) throw InputError({program, 0, ""}, "the program says nothing to --help");
  return text;
}

// "  --flag=TEXT            words", as DescribeFlag writes it.
FlagPage FlagOf(const std::string& line) {
  FlagPage flag;
  const size_t end = line.find_first_of(" =", 4);
  flag.name = line.substr(4, end - 4);
  flag.takes_value = end != std::string::npos && line[end] == '=';
  const size_t words = line.find_first_not_of(' ', line.find(' ', end));
  flag.words = words == std::string::npos ? "" : line.substr(words);
  return flag;
}

CommandPage PageOf(const Command& command) {
  const std::string help = command.program.empty() ? HelpOf(command) : HelpOfProgram(command.program);
  CommandPage page{command.name, command.summary, help.substr(0, help.find('\n')), "", {}};
  const size_t flags = help.rfind("\nFlags\n");
  page.description = help.substr(page.usage.size(), flags - page.usage.size());
  if (flags == std::string::npos) return page;
  for (const std::string& line : SplitText(help.substr(flags + 7), '\n')) {
    if (line.rfind("  --", 0) == 0) page.flags.push_back(FlagOf(line));
  }
  return page;
}

// Text of a manual page: no character is a request of troff.
std::string Roff(const std::string& text) {
  std::string roff;
  bool starts = true;
  for (const char c : text) {
    if (starts && (c == '.' || c == '\'')) roff += "\\&";
    roff += c == '\\' ? "\\e" : c == '-' ? "\\-" : c == '\'' ? "\\(aq" : std::string(1, c);
    starts = c == '\n';
  }
  return roff;
}

std::string Verbatim(const std::string& text) {
  const size_t first = text.find_first_not_of('\n');
  if (first == std::string::npos) return "";
  return ".nf\n" + Roff(text.substr(first, text.find_last_not_of('\n') - first + 1)) + "\n.fi\n";
}

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string ManualHead(const std::string& name, const std::string& summary) {
  return ".TH " + Upper(name) + " 1 \"\" \"sagitta " SAGITTA_VERSION "\"\n.SH NAME\n" + Roff(name) + " \\- " +
         Roff(summary) + "\n";
}

constexpr const char* kExitStatus =
    ".SH EXIT STATUS\n0 done; 1 done, but a requirement is not met; 2 input or usage error; 3 numerical failure\n";

std::string ManOf(const CommandPage& page) {
  std::string man = ManualHead("sagitta-" + page.name, page.summary) + ".SH SYNOPSIS\n.B " + Roff(page.usage) +
                    "\n.SH DESCRIPTION\n" + Verbatim(page.description) + ".SH OPTIONS\n";
  for (const FlagPage& flag : page.flags) {
    man += ".TP\n.B \\-\\-" + Roff(flag.name) + (flag.takes_value ? "=…" : "") + "\n" + Roff(flag.words) + "\n";
  }
  return man + kExitStatus + ".SH SEE ALSO\n.BR sagitta (1)\n";
}

std::string ManOfAll(const std::vector<CommandPage>& pages, const std::string& overview) {
  std::string man = ManualHead("sagitta", "robot calibration from measured points") +
                    ".SH SYNOPSIS\n.B sagitta COMMAND …\n.SH DESCRIPTION\n" + Verbatim(overview) + kExitStatus +
                    ".SH SEE ALSO\n";
  for (size_t i = 0; i < pages.size(); ++i) {
    man += ".BR sagitta\\-" + Roff(pages[i].name) + " (1)" + (i + 1 < pages.size() ? "," : "") + "\n";
  }
  return man;
}

std::string BashOf(const std::vector<CommandPage>& pages) {
  std::string names, cases;
  for (const CommandPage& page : pages) {
    names += page.name + " ";
    cases += "    " + page.name + ") flags='";
    for (const FlagPage& flag : page.flags) cases += "--" + flag.name + (flag.takes_value ? "= " : " ");
    cases += "--help' ;;\n";
  }
  return R"(# bash completion of sagitta, made of its command table
_sagitta() {
  local cur=${COMP_WORDS[COMP_CWORD]} flags=''
  local commands=')" +
         names + R"('
  COMPREPLY=()
  [[ $cur == = ]] && cur=''
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "$commands help --help --version" -- "$cur")
    return
  fi
  case ${COMP_WORDS[1]} in
    help) mapfile -t COMPREPLY < <(compgen -W "$commands" -- "$cur"); return ;;
)" + cases +
         R"(  esac
  if [[ $cur == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$flags" -- "$cur")
    [[ ${COMPREPLY[0]-} == *= ]] && compopt -o nospace 2>/dev/null
  else
    mapfile -t COMPREPLY < <(compgen -f -- "$cur")
    compopt -o filenames 2>/dev/null
  fi
  return 0
}
complete -F _sagitta sagitta
)";
}

// Inside single quotes, and inside a specification of _arguments or _describe.
std::string Zsh(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\'') {
      escaped += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
      escaped += c;
    }
  }
  return escaped;
}

std::string ZshOf(const std::vector<CommandPage>& pages) {
  std::string names, cases;
  for (const CommandPage& page : pages) {
    names += "    '" + page.name + ":" + Zsh(page.summary) + "'\n";
    cases += "    " + page.name + ") _arguments \\\n";
    for (const FlagPage& flag : page.flags) {
      cases += "      '--" + flag.name + (flag.takes_value ? "=" : "") + "[" + Zsh(flag.words) + "]" +
               (flag.takes_value ? ":value:_files" : "") + "' \\\n";
    }
    cases += "      '*:file:_files' ;;\n";
  }
  return "#compdef sagitta\n# zsh completion of sagitta, made of its command table\n_sagitta() {\n  local -a "
         "commands=(\n" +
         names +
         "  )\n  if ((CURRENT == 2)); then\n    _describe command commands\n    return\n  fi\n"
         "  shift words\n  ((CURRENT--))\n  case $words[1] in\n    help) _describe command commands ;;\n" +
         cases + "  esac\n}\n_sagitta \"$@\"\n";
}

}  // namespace

void WriteShellPages(const std::vector<Command>& commands, const std::string& overview, const std::string& folder) {
  std::vector<CommandPage> pages;
  for (const Command& command : commands) pages.push_back(PageOf(command));
  const NewFolders man(folder + "/man"), bash(folder + "/bash"), zsh(folder + "/zsh");
  WriteTextFile(folder + "/man/sagitta.1", ManOfAll(pages, overview));
  for (const CommandPage& page : pages) WriteTextFile(folder + "/man/sagitta-" + page.name + ".1", ManOf(page));
  WriteTextFile(folder + "/bash/sagitta", BashOf(pages));
  WriteTextFile(folder + "/zsh/_sagitta", ZshOf(pages));
}

}  // namespace sagitta
