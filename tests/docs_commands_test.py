#!/usr/bin/env python3
"""docs/commands/ says what the program says: the upper part of each page, and the list of pages, are made of the command
table, as the manual pages are; below it stands an example, which docs_test.py runs.

usage: docs_commands_test.py PROGRAM [--write]
"""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = ROOT / 'docs' / 'commands'
MADE = '<!-- Made of the command table, down to the next such line: tests/docs_commands_test.py PROGRAM --write -->\n'
END = '<!-- End of what is made. -->\n'
GROUPS = (  # in the order in which people need them
    ('Bring files over', ('import', 'convert')),
    ('Estimate', ('inspect', 'calibrate', 'diagnose')),
    ('Judge', ('validate', 'predict', 'coverage', 'compare', 'changed')),
    ('Use', ('compensate', 'plan', 'simulate')),
    ('Check the project itself', ('reproduce',)),
)


def said(program, *words):
    done = subprocess.run([program, *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit('%s %s ends with %d' % (program, ' '.join(words), done.returncode))
    return done.stdout


def summaries(program):
    return dict(re.findall(r'^  ([a-z]+)  +(\S.*)$', said(program, '--help'), re.MULTILINE))


def cell(text):
    return text.replace('|', '\\|').replace('*', '\\*').replace('<', '&lt;')


def sentence(text):
    return text[0].upper() + text[1:] + '.'


def made_part(program, name, summary):
    usage, _, rest = said(program, name, '--help').partition('\n')
    description, _, flags = rest.rpartition('\nFlags\n')
    rows = [(flag, words.strip()) for flag, words in re.findall(r'^  (--\S+)(.*)$', flags, re.MULTILINE)]
    table = ''.join('| `%s` | %s |\n' % (flag, cell(words)) for flag, words in rows)
    return ('%s\n# sagitta %s\n\n%s\n\n```\n%s\n\n%s\n```\n\n| flag | means |\n|---|---|\n%s\nExit status: 0 done; 1 done, but '
            'a requirement is not met; 2 input or usage error; 3 numerical failure. [All commands](README.md)\n\n%s'
            % (MADE, name, sentence(summary), usage, description.strip('\n'), table, END))


def overview(found):
    text = MADE + '\n# Commands\n\n`sagitta COMMAND --help` says the same in a terminal. The examples are run from the root of a checkout, with\n`build/release/bin` on the PATH. A default stands in brackets, as in [joint].\n'
    for group, names in GROUPS:
        text += '\n## %s\n\n| command | |\n|---|---|\n' % group
        text += ''.join('| [`%s`](%s.md) | %s |\n' % (name, name, cell(found[name])) for name in names)
    return text


def main(program, write):
    found = summaries(program)
    grouped = [name for _, names in GROUPS for name in names]
    defects = []
    if sorted(grouped) != sorted(found):
        sys.exit('GROUPS has %s, the program %s' % (sorted(grouped), sorted(found)))
    texts = {'README.md': overview(found)}
    for name, summary in found.items():
        page = PAGES / (name + '.md')
        old = page.read_text(encoding='utf-8') if page.exists() else ''
        _, end, by_hand = old.partition(END)
        texts[page.name] = made_part(program, name, summary) + (by_hand if end else '\n## Example\n')
        if '\n## Example\n' not in by_hand or '```sh\n' not in by_hand:
            defects.append('docs/commands/%s: no example' % page.name)
    for name, text in texts.items():
        page = PAGES / name
        if write:
            page.write_text(text, encoding='utf-8')
        elif not page.exists() or page.read_text(encoding='utf-8') != text:
            defects.append('docs/commands/%s is not what the program says: tests/docs_commands_test.py PROGRAM --write' % name)
    extra = {page.name for page in PAGES.glob('*.md')} - set(texts)
    defects += ['docs/commands/%s is of no command' % name for name in sorted(extra)]
    print('\n'.join(defects) if defects else '%d pages of commands are as the program says' % len(found))
    return 1 if defects else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1], '--write' in sys.argv[2:]))
