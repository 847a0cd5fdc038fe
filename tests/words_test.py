#!/usr/bin/env python3
"""Sentences use the words of the field: where one holds a word of the table INSTEAD, a word that stands opposite says
more exactly what is meant, and one thing has one word on the pages, in comments and in messages.

Three classes of text are read: `pages` (*.md without blocks), `comments` (of C++, JavaScript, CSS, Python, shell, CMake
and YAML; docstrings too) and `strings` (literals with a blank of C++, JavaScript and Python; others are keys). What
stands in `backquotes` is a name and is not read. An exception that nothing needs any more fails, too. Standard library
only.

usage: words_test.py [ROOT]            check the tree (default: the one this file is in)
       words_test.py --list [CLASS…]   every finding of these classes (default: all), exceptions included
       words_test.py --self-test       prove that planted words are found, and nothing else
"""
import ast
import fnmatch
import io
import pathlib
import re
import subprocess
import sys
import tempfile
import tokenize

CLASSES = ('pages', 'comments', 'strings')

INSTEAD = {
    'tell': 'distinguish A from B; the data do not determine X; state; estimate; reveal',
    'tells': 'distinguishes; determines; states; estimates; reveals',
    'told': 'distinguished; determined; stated; reported',
    'telling': 'distinguishing; determining; stating',
    'beside': 'given, with, together with (statistics); next to (place); compared with',
    'besides': 'in addition; also; as well as; other than',
    'take': 'assume; read; accept; use; remove (take out); need (time); adopt (take over); absorb (take up)',
    'takes': 'assumes; reads; accepts; uses; removes; needs; adopts; absorbs; replaces (takes the place of)',
    'taken': 'assumed; read; mistaken for; used; removed; measured (points)',
    'took': 'assumed; read; used; removed; needed',
    'taking': 'assuming; reading; using; removing',
}

EXCEPTIONS = {  # (file, text of the line; '': any): why
    ('third_party_notes/README.md', ''): 'describes the work of others',
}

# Parts of a compound (take-off) are other words.
WORD = re.compile(r'(?<![\w-])(?:%s)(?![\w-])' % '|'.join(sorted(INSTEAD, key=len, reverse=True)), re.IGNORECASE)
CODE = re.compile(r'`[^`\n]*`')
FENCE = re.compile(r'^```.*?^```$', re.MULTILINE | re.DOTALL)
CPP = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:[^"\\\n]|\\.)*"|'
                 r'(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)  # no separator of digits: 1'000
SHEBANG = re.compile(r'#!.*\b(python3|bash|sh)\b')
SCRIPTS = {'.py': 'python', '.pyi': 'python', '.sh': 'sh', '.cmake': 'sh', '.yaml': 'sh', '.yml': 'sh'}
HASH = re.compile(r'(?:^|(?<=\s))#[^\n]*', re.MULTILINE)


def of_page(text):
    """The prose of a page, line by line; blocks leave their lines empty."""
    yield 'pages', 1, FENCE.sub(lambda m: '\n' * m.group().count('\n'), text)


def of_cpp(text):
    for match in CPP.finditer(text):
        literal = match.group()
        kind = 'comments' if literal[0] == '/' else 'strings'
        if kind == 'comments' or ' ' in literal:
            yield kind, text.count('\n', 0, match.start()) + 1, literal


def docstring_lines(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node, False) is not None:
            yield node.body[0].lineno


def of_python(text):
    docstrings = set(docstring_lines(text))
    literals = (tokenize.STRING, getattr(tokenize, 'FSTRING_MIDDLE', None))  # parts of f-strings, from Python 3.12 on
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT or token.type == tokenize.STRING and token.start[0] in docstrings:
            yield 'comments', token.start[0], token.string
        elif token.type in literals and ' ' in token.string:
            yield 'strings', token.start[0], token.string


def of_shell(text):
    for match in HASH.finditer(text):
        yield 'comments', text.count('\n', 0, match.start()) + 1, match.group()


def reader(name, text):
    path = pathlib.PurePath(name)
    if path.suffix == '.md':
        return of_page
    if path.suffix in ('.cc', '.h', '.js', '.css'):
        return of_cpp
    script = SHEBANG.match(text)
    language = SCRIPTS.get(path.suffix) or path.name == 'CMakeLists.txt' and 'sh' or script and script.group(1)
    return {'python': of_python, 'python3': of_python, 'sh': of_shell, 'bash': of_shell}.get(language)


def findings(name, text):
    """Class, line and word of every word of the table, and the line's text."""
    lines = text.split('\n')
    read = reader(name, text)
    for kind, first, piece in read(text) if read else ():
        for number, line in enumerate(piece.split('\n'), first):
            for match in WORD.finditer(CODE.sub('``', line)):
                yield kind, number, match.group().lower(), lines[number - 1].strip()


def tree(root):
    """Names and texts of the files of a checkout, or of a copy without its history; not this one, with its table."""
    git = subprocess.run(['git', 'ls-files', '--cached', '--others', '--exclude-standard'], cwd=root,
                         capture_output=True, text=True, check=False)
    names = git.stdout.splitlines() or [p.relative_to(root).as_posix() for p in root.rglob('*')]
    for name in sorted(names):
        path = root / name
        if (path.is_file() and not name.startswith(('build/', '.git/')) and path.stat().st_size < 1 << 20
                and name != 'tests/words_test.py'):
            yield name, path.read_text(encoding='utf-8', errors='replace')


def violations(root, on, exceptions):
    """What is wrong with the tree in the classes `on`, and how many files were read."""
    found, used, looked_at = [], set(), 0
    for name, text in tree(root):
        looked_at += reader(name, text) is not None
        for kind, number, word, line in findings(name, text):
            excuse = [key for key in exceptions if fnmatch.fnmatchcase(name, key[0]) and key[1] in line]
            if kind in on:
                used.update(excuse)
            if kind in on and not excuse:
                found.append('%s:%d: %s, "%s": rather %s\n    %s' % (name, number, kind, word, INSTEAD[word], line))
    for key in sorted(set(exceptions) - used):
        found.append('tests/words_test.py: nothing needs the exception of %s %s' % key)
    return found, looked_at


PLANTED = [  # (file, text, class and line of what is found)
    ('a.md', 'a\nThe data cannot tell it.\n', [('pages', 2)]),
    ('a.md', 'Beside\n\n```text\ntold\n```\n\nA take-off, `take` and intake; taken.\n', [('pages', 1), ('pages', 7)]),
    ('a.cc', 'int a;  // taken\n/* one\n   told */\n', [('comments', 1), ('comments', 3)]),
    ('a.cc', 'Say("it takes long");\nSay("a // b", "take");\nint take = told(beside);\n', [('strings', 1)]),
    ('a.h', 'R"(one\n  taken)" + "\\"told // it"\n', [('strings', 2), ('strings', 2)]),
    ('a.h', "const int n = 1'000;  // besides\nchar q = '\"';  // took\n", [('comments', 1), ('comments', 2)]),
    ('a.py', '"""What is told."""\n\n\ndef take():\n    """Tells."""\n    return "a # b", f"taken as {1}"  # taking\n',
     [('comments', 1), ('comments', 5), ('comments', 6), ('strings', 6)]),
    ('a/run', '#!/usr/bin/env bash\ntake "a#told"  # besides\n', [('comments', 2)]),
    ('a/run', '#!/usr/bin/env python3\ntake = 1  # besides\n', [('comments', 2)]),
    ('CMakeLists.txt', '# telling\nset(TAKE beside)\n', [('comments', 1)]),
    ('a.yaml', 'what: taken  # told\n', [('comments', 1)]),
    ('a.csv', 'taken\n', []),
]


def self_test():
    wrong = 0
    for name, text, expected in PLANTED:
        found = sorted((kind, line) for kind, line, _, _ in findings(name, text))
        if found != sorted(expected):
            wrong += 1
            print('FAIL  %s %r: found %r' % (name, text, found))
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / 'a.md').write_text('What is taken.\n')
        on, off = CLASSES, ()
        # Found; not of a class that is off; not where an exception lets it pass, which is found once nothing needs it.
        for switched, exceptions, expected in ((on, {}, 1), (off, {}, 0), (on, {('*.md', 'What'): ''}, 0),
                                               (on, {('*.md', 'Who'): ''}, 2), (off, {('*.md', 'What'): ''}, 1)):
            found, looked_at = violations(root, switched, exceptions)
            if len(found) != expected or looked_at != 1:
                wrong += 1
                print('FAIL  %d findings instead of %d with %r' % (len(found), expected, exceptions))
    print('%d planted cases, %d wrong' % (len(PLANTED) + 5, wrong))
    return 1 if wrong else 0


def main(arguments):
    if arguments == ['--self-test']:
        return self_test()
    is_list = arguments[:1] == ['--list']
    root = pathlib.Path(arguments[0] if arguments and not is_list else pathlib.Path(__file__).parent.parent).resolve()
    if is_list:
        wanted = arguments[1:] or CLASSES
        print('\n'.join(violations(root, wanted, {})[0]))
        return 0
    found, looked_at = violations(root, CLASSES, EXCEPTIONS)
    print('\n'.join(found) if found else '%d files use the words of the field; %d exceptions, each with its reason'
          % (looked_at, len(EXCEPTIONS)))
    return 1 if found or looked_at < 100 else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
