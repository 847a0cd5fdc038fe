#!/usr/bin/env python3
"""The pages are true: their commands are run as printed, and what they show is what the program prints.

usage: docs_test.py PROGRAM PAGE…  [--write]
  --write  puts the numbers that are printed now into the pages; words that changed are for people
"""
import pathlib
import subprocess
import sys
import tempfile

import docs_pages

ROOT = docs_pages.ROOT
SHOWN_PROGRAM = 'build/release/bin/sagitta'
README_LINES = 120
NOT_RUN = ('tests/run',)  # it is what runs this


def only(blocks, start):
    found = [block.text for block in blocks if block.text.startswith(start)]
    if len(found) != 1:
        raise SystemExit('README.md: %d blocks begin with %r, one is expected' % (len(found), start))
    return found[0]


def readme():
    """The two-file example: the robot block, the measurement block, the command; and the length of the page."""
    text = (ROOT / 'README.md').read_text(encoding='utf-8')
    if len(text.splitlines()) > README_LINES:
        yield 'README.md: %d lines, more than %d' % (len(text.splitlines()), README_LINES)
    blocks = docs_pages.blocks_of(text)
    for command in ('tools/demo', 'tests/run'):
        if command + '\n' not in [block.text for block in blocks]:
            yield 'README.md: no block that is %s' % command
    shell = [block for block in blocks if block.language == 'sh']
    unmarked = [block.text for block in blocks if block.language == '' and block.text.startswith(('tools/', 'build/'))]
    if unmarked or not shell:
        yield 'README.md: commands that are not in a block of sh: %s' % unmarked


def two_files(program):
    blocks = docs_pages.blocks_of((ROOT / 'README.md').read_text(encoding='utf-8'))
    command = only(blocks, SHOWN_PROGRAM + ' calibrate ROBOT.yaml MEAS.csv')
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, 'ROBOT.yaml').write_text(only(blocks, 'schema: sagitta/robot/1'))
        pathlib.Path(folder, 'MEAS.csv').write_text(only(blocks, 'config,marker,'))
        run = subprocess.run([program] + command.split()[1:], cwd=folder, capture_output=True, text=True, check=False)
        written = sorted(path.name for path in pathlib.Path(folder, 'DIR').glob('*'))
    if run.returncode != 0:
        yield 'README.md: %s ends with %d\n%s' % (command.strip(), run.returncode, run.stderr)
    elif written != ['estimate.json', 'report.html', 'residuals.csv', 'robot.calibrated.yaml']:
        yield 'README.md: the example writes %s' % written


def main(program, arguments):
    program = str(pathlib.Path(program).resolve())
    pages = [argument for argument in arguments if not argument.startswith('--')]
    found = []
    for page in pages:
        not_run = NOT_RUN
        if page == 'README.md':
            found += list(readme()) + list(two_files(program))
            blocks = docs_pages.blocks_of((ROOT / page).read_text(encoding='utf-8'))
            not_run += (only(blocks, SHOWN_PROGRAM + ' calibrate ROBOT.yaml MEAS.csv').strip(),)  # two_files
        found += docs_pages.check(page, program, '--write' in arguments, not_run,
                                  is_on_path=page.startswith('docs/commands/'))
    print('\n'.join(found) if found else 'what is printed in %s runs as printed' % ', '.join(pages))
    return 1 if found or not pages else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1], sys.argv[2:]))
