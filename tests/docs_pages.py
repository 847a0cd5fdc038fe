"""What the tests of the pages share: the blocks of a page, running them as printed, comparing what is shown.

A block ```sh is run, by bash, from the root of a checkout. The block ```text that follows it is what the commands print:
all of it, or parts of it with a line "…" for what is left out. Words have to be the same; a number may differ by 0.5 %
because compilers differ. Files in blocks ```yaml are read by docs_blocks_test.py; other blocks are not run.
"""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BLOCK = re.compile(r'^```(\w*)\n(.*?)^```$', re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r'(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])')
LEFT_OUT = '…'
BETWEEN = '\x1e'
LINKED = ('docs', 'problems', 'tests', 'estimator', 'models')  # what commands read of a checkout


class Block:
    def __init__(self, match):
        self.language, self.text = match.groups()
        self.begin, self.end = match.start(2), match.end(2)


def blocks_of(text):
    return [Block(match) for match in BLOCK.finditer(text)]


def steps_of(text):
    """Pairs of a block that is run and the block that shows what it prints, or None."""
    blocks = blocks_of(text)
    for block, following in zip(blocks, blocks[1:] + [None]):
        if block.language == 'sh':
            yield block, following if following is not None and following.language == 'text' else None


class Scratch:
    """A folder that looks like a checkout in which the program has been built; what commands write stays in it."""

    def __init__(self, program):
        self.program = pathlib.Path(program).resolve()

    def __enter__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix='sagitta-pages-'))
        for name in LINKED:
            (self.folder / name).symlink_to(ROOT / name)
        (self.folder / 'tools').mkdir()
        for path in (ROOT / 'tools').iterdir():
            if path.name != 'install-dependencies':
                (self.folder / 'tools' / path.name).symlink_to(path)
        (self.folder / 'build' / 'release').mkdir(parents=True)
        (self.folder / 'build' / 'release' / 'bin').symlink_to(self.program.parent)
        (self.folder / 'build' / 'release' / 'build.ninja').write_text('sagitta_hidden_generator\n')
        # Whoever runs this has installed and built.
        self.done = self.folder / 'done'
        self.done.mkdir()
        for stub in (self.done / 'cmake', self.folder / 'tools' / 'install-dependencies'):
            stub.write_text('#!/bin/sh\n')
            stub.chmod(0o755)
        return self

    def __exit__(self, *error):
        shutil.rmtree(self.folder)

    def run(self, commands, is_on_path):
        """What each of the blocks printed, and the words of a failure or ''."""
        script = 'set -e\n' + ''.join('%s\nprintf "\\036"\n' % block.text for block in commands)
        folders = [str(self.done)] + [str(self.program.parent)] * is_on_path + [os.environ['PATH']]
        environment = dict(os.environ, LC_ALL='C.UTF-8', PATH=':'.join(folders))
        done = subprocess.run(['bash', '-c', script], cwd=self.folder, capture_output=True, text=True, check=False,
                              env=environment)
        printed = done.stdout.split(BETWEEN)
        if done.returncode == 0:
            return printed[:-1], ''
        failed = commands[len(printed) - 1].text.strip()
        return printed, '%s\n  ends with %d\n%s%s' % (failed, done.returncode, printed[-1], done.stderr)


def plain(line):
    return ' '.join(line.split())


def words_of(line):
    return NUMBER.sub('#', plain(line))


def numbers_agree(shown, printed):
    pairs = zip(NUMBER.findall(plain(shown)), NUMBER.findall(plain(printed)))
    return all(abs(float(a) - float(b)) <= 0.005 * abs(float(a)) for a, b in pairs)


def chunks_of(shown):
    """Runs of lines between lines that say that something is left out."""
    chunk, chunks = [], []
    for line in shown.rstrip('\n').split('\n'):
        if line.strip() == LEFT_OUT:
            chunks.append(chunk)
            chunk = []
        else:
            chunk.append(line)
    return chunks + [chunk]


def compared(shown, printed):
    """The lines as the program prints them now, and what differs, in words."""
    lines = printed.strip('\n').split('\n')
    chunks = chunks_of(shown)
    now, at, differs = [], 0, []
    for index, chunk in enumerate(chunks):
        if index > 0:
            now.append(LEFT_OUT)
        if not chunk:
            continue
        wanted = [words_of(line) for line in chunk]
        first, last = index == 0, index == len(chunks) - 1
        places = [p for p in range(at, len(lines) - len(chunk) + 1)
                  if [words_of(line) for line in lines[p:p + len(chunk)]] == wanted
                  and (not first or p == 0) and (not last or p + len(chunk) == len(lines))]
        if not places:
            differs.append('it does not print, in this place:\n' + '\n'.join('    ' + line for line in chunk))
            now += chunk
            continue
        found = lines[places[0]:places[0] + len(chunk)]
        differs += ['shown:   %s\nprinted: %s' % (plain(a), plain(b)) for a, b in zip(chunk, found)
                    if not numbers_agree(a, b)]
        now += [line.rstrip() for line in found]
        at = places[0] + len(chunk)
    return '\n'.join(now) + '\n', differs


def check(page, program, write=False, not_run=(), is_on_path=False):
    """Words on what differs. With `write`, numbers that are shown become those that are printed.

    `is_on_path`: the page assumes `sagitta` to be installed.
    """
    path = ROOT / page
    text = path.read_text(encoding='utf-8')
    steps = [(block, shown) for block, shown in steps_of(text) if block.text.strip() not in not_run]
    if not steps:
        return
    with Scratch(program) as scratch:
        printed, failure = scratch.run([block for block, _ in steps], is_on_path)
    if failure:
        yield '%s: %s' % (page, failure)
        return
    replaced = text
    for (block, shown), output in reversed(list(zip(steps, printed))):
        if shown is None:
            continue
        now, differs = compared(shown.text, output)
        if differs:
            yield '%s: %s\n%s' % (page, block.text.strip(), '\n'.join(differs))
            yield 'all of what it printed:\n' + output
        replaced = replaced[:shown.begin] + now + replaced[shown.end:]
    if write and replaced != text:
        path.write_text(replaced, encoding='utf-8')
