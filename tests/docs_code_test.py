#!/usr/bin/env python3
"""Code in docs/LIBRARY.md is code that tests/consumer builds and runs: each block is one of its files, whole.

Standard library only. usage: docs_code_test.py
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).parent.parent


def main():
    page = (ROOT / 'docs' / 'LIBRARY.md').read_text(encoding='utf-8')
    files = [p for p in sorted((ROOT / 'tests' / 'consumer').iterdir()) if p.suffix in ('.cc', '.txt')]
    texts = {p.read_text(encoding='utf-8').strip(): p.name for p in files}
    blocks = [block.strip() for block in re.findall(r'```(?:cpp|cmake)\n(.*?)```', page, re.DOTALL)]
    unknown = [block.splitlines()[0] for block in blocks if block not in texts]
    unshown = sorted(set(texts.values()) - {texts[block] for block in blocks if block in texts})
    for line in unknown:
        print("docs/LIBRARY.md shows code that is none of tests/consumer: '%s …'" % line)
    for name in unshown:
        print('docs/LIBRARY.md does not show tests/consumer/' + name)
    if not unknown and not unshown:
        print('%d blocks of docs/LIBRARY.md are the files of tests/consumer' % len(blocks))
    return 1 if unknown or unshown else 0


if __name__ == '__main__':
    sys.exit(main())
