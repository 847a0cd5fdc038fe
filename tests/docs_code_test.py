#!/usr/bin/env python3
"""Code in docs/LIBRARY.md is code that tests/consumer builds and runs, and code in docs/PYTHON.md that of tools/examples:
each block is one of the files, whole.

Standard library only. usage: docs_code_test.py
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).parent.parent


PAGES = [  # page, languages, folder, suffixes of what it shows
    ('docs/LIBRARY.md', 'cpp|cmake', 'tests/consumer', ('.cc', '.txt')),
    ('docs/PYTHON.md', 'python|cpp', 'tools/examples', ('.py', '.cc')),
]


def defects(page, languages, folder, suffixes):
    text = (ROOT / page).read_text(encoding='utf-8')
    files = [p for p in sorted((ROOT / folder).iterdir()) if p.suffix in suffixes]
    texts = {p.read_text(encoding='utf-8').strip(): p.name for p in files}
    blocks = [block.strip() for block in re.findall(r'```(?:%s)\n(.*?)```' % languages, text, re.DOTALL)]
    for block in blocks:
        if block not in texts:
            yield "%s shows code that is none of %s: '%s …'" % (page, folder, block.splitlines()[0])
    for name in sorted(set(texts.values()) - {texts[block] for block in blocks if block in texts}):
        yield '%s does not show %s/%s' % (page, folder, name)
    if not blocks:
        yield page + ' shows no code'


def main():
    found = [defect for page in PAGES for defect in defects(*page)]
    print('\n'.join(found) if found else 'the blocks of %s are files that are run' % ' and '.join(p[0] for p in PAGES))
    return 1 if found else 0


if __name__ == '__main__':
    sys.exit(main())
