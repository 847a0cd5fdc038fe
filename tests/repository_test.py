#!/usr/bin/env python3
"""What a checkout must keep: no paths of somebody's machine, no large files, no
source a newcomer gets lost in, scripts that can be run, gates of tests that exist. Standard library only."""
import fnmatch
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
MAX_BYTES = 2_000_000
MAX_LINES = 500
PLAIN_NAME = re.compile(r'[\w.+/-]+', re.ASCII)
EMPTY = {'__init__.py', 'py.typed'}
GENERATED = {'.git', 'build', 'results', '__pycache__'}
# Of C: it reads 1.5 as 1 where a program around the library has set a locale with a comma.
READS_BY_LOCALE = re.compile(r'\b(?:sto(?:d|f|ld)|strto(?:d|f|ld)|atof|sscanf)\(')
COMPILED_ALONE = ('models/batch/', 'models/effects/learnt_')
LAYERS = ('models', 'problems', 'estimator', 'tools')
SOURCES = ('models/', 'problems/', 'estimator/', 'tools/', 'python/')
SHARED_PARENTS = {'/', '/tmp', '/opt', '/srv', '/mnt', '/usr/src', '/usr/local/src'}


def files():
    git = subprocess.run(['git', 'ls-files', '-z'], cwd=ROOT, capture_output=True, text=True)
    return [name for name in git.stdout.split('\0') if name and (ROOT / name).is_file()]


def files_without_git():
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [f for f in folders if f not in GENERATED]
        yield from (os.path.relpath(os.path.join(folder, name), ROOT) for name in names)


def machine_paths():
    patterns = [r'/(?:home|Users)/\w', r'/ro{2}t/']
    if str(ROOT.parent) not in SHARED_PARENTS:
        patterns.append(re.escape(str(ROOT.parent)) + '/')
    return re.compile(r'(?<![\w.*}])(?:%s)' % '|'.join(patterns))


def defects(name, machine_path):
    path = ROOT / name
    content = path.read_bytes()
    if not PLAIN_NAME.fullmatch(name):
        yield '%s: a name that a shell reads as something else' % name
    if not content and path.name not in EMPTY:
        yield '%s: an empty file' % name
    if len(content) > MAX_BYTES:
        yield '%s: %d bytes, more than %d' % (name, len(content), MAX_BYTES)
    is_script = content.startswith(b'#!')
    if is_script != os.access(path, os.X_OK):
        yield '%s: %s' % (name, 'a script without the x bit' if is_script else 'the x bit on what is no script')
    if b'\0' in content:
        return
    lines = content.decode('utf-8', errors='replace').splitlines()
    if path.suffix in ('.cc', '.h') and len(lines) > MAX_LINES:
        yield '%s: %d lines, more than %d' % (name, len(lines), MAX_LINES)
    for number, line in enumerate(lines, 1):
        if name.startswith(SOURCES) and path.suffix in ('.cc', '.h') and READS_BY_LOCALE.search(line):
            yield '%s:%d: a number read in the program\'s locale; ParseNumber reads the same in all' % (name, number)
        if machine_path.search(line):
            yield '%s:%d: a path of one machine: %s' % (name, number, line.strip()[:80])


def repeated_names(names):
    """Constants and types of unnamed namespaces that several sources of a library have: which of them are compiled
    together changes with every new source. A folder of tools/ is a program or a library."""
    seen = {}
    for name in names:
        if not name.endswith('.cc') or not name.startswith(SOURCES) or name.startswith(COMPILED_ALONE):
            continue
        text = (ROOT / name).read_text(encoding='utf-8')
        library = name.rsplit('/', 1)[0] if name.startswith('tools/') else name.split('/')[0]
        for space in re.finditer(r'^namespace \{\n(.*?)^\}  // namespace$', text, re.MULTILINE | re.DOTALL):
            around = re.findall(r'^(?:namespace|\}  // namespace) ([\w:]+)(?= \{|$)', text[:space.start()],
                                re.MULTILINE)
            if [n for n in around if around.count(n) % 2] != ['sagitta']:
                continue  # in a namespace of its own
            constants = ''.join(re.findall(r'^const(?:expr)? [^;]*;', space.group(1), re.MULTILINE))
            own = re.findall(r'\b(k[A-Z]\w*)(?:\[\w*\])?\s*=', constants)
            own += re.findall(r'^(?:struct|class|enum class) (\w+)', space.group(1), re.MULTILINE)
            for each in set(own):
                seen.setdefault((library, each), []).append(name)
    for (library, each), sources in sorted(seen.items()):
        if len(sources) > 1:
            yield '%s: %s stands in unnamed namespaces of %s' % (library, each, ' and '.join(sources))


def outdated_examples():
    """Code of a page that is compiled elsewhere: every block stands there word for word."""
    compiled = (ROOT / 'tests/support/driven_harmonic.h').read_text(encoding='utf-8')
    page = (ROOT / 'docs/ADDING_AN_EFFECT.md').read_text(encoding='utf-8')
    for block in re.findall(r'```cpp\n(.*?)```', page, re.DOTALL):
        if block.strip() not in compiled:
            yield 'docs/ADDING_AN_EFFECT.md: not the code of tests/support/driven_harmonic.h: %s' % block[:60].strip()


def unsaid_gates():
    """`tests/run --help` says what each gate is, and builds nothing."""
    script = ROOT / 'tests/run'
    said = subprocess.run([script, '--help'], capture_output=True, text=True, timeout=60).stdout
    for gate in re.findall(r'^gate_(\w+)\(\)', script.read_text(encoding='utf-8'), re.MULTILINE):
        if not re.search(r'^  %s +\S' % gate, said, re.MULTILINE):
            yield 'tests/run: --help does not say what the gate %s is' % gate


def threads_gate_in_vain():
    """Every pattern of the gate `threads` finds a test in the program that it runs, every source of that has one."""
    gates, targets = ((ROOT / 'tests' / name).read_text(encoding='utf-8') for name in ('run', 'CMakeLists.txt'))
    patterns = ''.join(re.findall(r"^thread_tests\+?='(.*)'$", gates, re.MULTILINE)).split(':')
    program = re.search(r'add_executable\(sagitta_thread_tests(.*?)\)', targets, re.DOTALL)
    tests = {source: ['.'.join(names) for names in re.findall(
        r'^TEST(?:_[FP])?\((\w+), (\w+)\)', (ROOT / 'tests' / source).read_text(encoding='utf-8'), re.MULTILINE)]
        for source in re.findall(r'\S+_test\.cc', program.group(1))}
    found = {(source, pattern) for source, names in tests.items() for pattern in patterns
             if fnmatch.filter(names, pattern.split('/')[-1])}
    for pattern in sorted(set(patterns) - {pattern for _, pattern in found}):
        yield 'tests/run: no test of sagitta_thread_tests is called %s' % pattern
    for source in sorted(set(tests) - {source for source, _ in found}):
        yield 'tests/CMakeLists.txt: the gate threads runs no test of %s' % source


def misplaced_tests(names):
    """A test stands in the folder of the source that it is named after, and in no folder that its layer does not have."""
    sources = {}
    for path in map(pathlib.Path, names):
        if path.suffix in ('.cc', '.h') and path.parts[0] in LAYERS:
            sources.setdefault((path.parts[0], path.stem), set()).add(path.parent)
    folders = {folder for places in sources.values() for folder in places}
    for name in names:
        path = pathlib.Path(name)
        if path.parts[0] != 'tests' or path.parts[1] not in LAYERS or not name.endswith('_test.cc'):
            continue
        folder = path.parent.relative_to('tests')
        if folder not in folders:
            yield '%s: no folder %s' % (name, folder)
        wanted = sources.get((path.parts[1], path.stem[:-len('_test')]), {folder})
        if len(folder.parts) > 1 and folder not in wanted:
            yield '%s: its source is in %s' % (name, ', '.join(map(str, sorted(wanted))))


def unnamed_packages():
    """README names the packages that the program is built with: those of tools/install-dependencies."""
    script = (ROOT / 'tools/install-dependencies').read_text(encoding='utf-8')
    needed = re.search(r'^build_packages=\((.*?)\)', script, re.DOTALL | re.MULTILINE).group(1).split()
    page = (ROOT / 'README.md').read_text(encoding='utf-8')
    named = re.search(r'Debian packages: `([^`]+)`', page)
    if named is None or named.group(1).split() != needed:
        yield "README.md: 'Debian packages: `…`' does not list those of tools/install-dependencies in its order"


def main():
    try:
        names = files()
    except OSError:  # no git
        names = []
    names = names or sorted(files_without_git())
    machine_path = machine_paths()
    found = [defect for name in names for defect in defects(name, machine_path)]
    found += [*outdated_examples(), *repeated_names(names), *unsaid_gates(), *threads_gate_in_vain(),
              *misplaced_tests(names), *unnamed_packages()]
    print('\n'.join(found) if found else '%d files, nothing to complain about' % len(names))
    return 1 if found or not names else 0


if __name__ == '__main__':
    sys.exit(main())
