#!/usr/bin/env python3
"""The pictures can be made as docs/TUTORIAL.md says, from the results of its commands, and say what the committed ones say.

usage: docs_pictures_test.py PROGRAM     (a Python with numpy, pandas and matplotlib)
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import docs_pages

PICTURES = docs_pages.ROOT / 'docs' / 'pictures'


def words_in(picture):
    return re.findall(r'<text[^>]*>([^<]*)</text>', picture.read_text(encoding='utf-8'))


def defects(program, out):
    tutorial = (docs_pages.ROOT / 'docs' / 'TUTORIAL.md').read_text(encoding='utf-8')
    with docs_pages.Scratch(program) as scratch:
        _, failure = scratch.run([block for block, _ in docs_pages.steps_of(tutorial)], is_on_path=True)
        if failure:
            yield failure
            return
        path = '%s:%s' % (scratch.program.parent, os.environ['PATH'])
        subprocess.run([sys.executable, str(PICTURES / 'make_pictures.py'), 'results', '--out', str(out)], check=True,
                       cwd=scratch.folder, env=dict(os.environ, PATH=path))
    committed, made = ({path.name: words_in(path) for path in folder.glob('*.svg')} for folder in (PICTURES, out))
    for name in sorted(committed.keys() | made.keys()):
        if committed.get(name) != made.get(name) or not made[name]:
            yield 'docs/pictures/%s: %s, made now: %s' % (name, committed.get(name), made.get(name))


def main(program):
    with tempfile.TemporaryDirectory() as out:
        found = list(defects(program, pathlib.Path(out)))
    print('\n'.join(found) if found else 'the pictures are made as the tutorial says')
    return 1 if found else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1]))
