#!/usr/bin/env python3
"""Every command and every flag of `sagitta --help` stands in the manual pages and in both completions; bash completes by
them, and groff and zsh find nothing wrong where they are installed. Standard library only.

usage: shell_pages_test.py PROGRAM FOLDER
"""
import pathlib
import re
import shutil
import subprocess
import sys


def said(*command, **options):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **options)


def completions(script, *words):
    quoted = " ".join("'%s'" % word for word in words)
    done = said("bash", "-c", "source '%s'; COMP_WORDS=(%s); COMP_CWORD=%d; _sagitta; printf '%%s\\n' \"${COMPREPLY[@]}\""
                % (script, quoted, len(words) - 1))
    return sorted(done.stdout.split()), done.stderr


def flags_of(help_text):
    return re.findall(r"^  --([a-z_0-9]+)", help_text[help_text.rindex("\nFlags\n"):], re.MULTILINE)


def plain(man):
    return man.replace("\\-", "-").replace("\\&", "").replace("\\(aq", "'").replace("\\e", "\\")


def defects(program, folder):
    overview = said(program, "--help").stdout
    commands = re.findall(r"^  ([a-z]+)  ", overview, re.MULTILINE)
    if len(commands) < 10:
        yield "the overview lists %s" % commands
    bash, zsh = folder / "bash" / "sagitta", folder / "zsh" / "_sagitta"
    zsh_text = zsh.read_text(encoding="utf-8")
    main_page = plain((folder / "man" / "sagitta.1").read_text(encoding="utf-8"))
    found, errors = completions(bash, "sagitta", "")
    if errors or set(commands) - set(found):
        yield "bash completes commands by %s %s" % (found, errors)
    for command in commands:
        help_text = said(program, command, "--help").stdout
        flags = flags_of(help_text)
        if not flags:
            yield "%s --help lists no flags" % command
        if "sagitta-%s" % command not in main_page:
            yield "sagitta.1 does not name sagitta-%s" % command
        page = plain((folder / "man" / ("sagitta-%s.1" % command)).read_text(encoding="utf-8"))
        for line in help_text[:help_text.rindex("\nFlags\n")].splitlines():
            if line.strip() and line not in page:
                yield "sagitta-%s.1 lacks the line: %s" % (command, line)
        found, errors = completions(bash, "sagitta", command, "--")
        if errors or sorted(word.strip("-=") for word in found) != sorted(flags + ["help"]):
            yield "bash completes %s by %s %s" % (command, found, errors)
        block = re.search(r"^    %s\) _arguments.*?;;" % command, zsh_text, re.MULTILINE | re.DOTALL)
        for flag in flags:
            if "\n.B --%s" % flag not in page:
                yield "sagitta-%s.1 lacks --%s" % (command, flag)
            if not block or not re.search(r"'--%s[=\[]" % flag, block.group(0)):
                yield "_sagitta lacks %s --%s" % (command, flag)
    if completions(bash, "sagitta", "calibrate", "--hold")[0] != ["--holdout="]:
        yield "bash does not complete --hold"
    for page in sorted((folder / "man").glob("*.1")):
        if shutil.which("groff"):
            done = said("groff", "-man", "-Tutf8", "-ww", "-Kutf8", "-rLL=130n", page)
            if done.returncode != 0 or done.stderr:
                yield "groff: %s: %s" % (page.name, done.stderr)
    if shutil.which("zsh"):
        done = said("zsh", "-n", zsh)
        if done.returncode != 0:
            yield "zsh: " + done.stderr


def main(program, folder):
    found = list(defects(program, pathlib.Path(folder)))
    print("\n".join(found) if found else "every command and flag is in the manual pages and in both completions")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
